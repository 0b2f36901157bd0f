#include "server/remote/environment_link.h"

#include <algorithm>

namespace espalier::server {

LinkFailure refusedWith(const protocol::Error& error) {
  constexpr std::size_t kMostBytes = 2000;
  LinkFailure failure{LinkFailure::Kind::Refused, "answered with an error: ", error};
  std::size_t length = std::min(error.message.size(), kMostBytes);
  // not within a character of UTF-8
  while (length < error.message.size() && length > 0 &&
         (static_cast<unsigned char>(error.message[length]) & 0xC0U) == 0x80U) {
    --length;
  }
  failure.message.append(error.message, 0, length);
  if (length < error.message.size()) {
    failure.message += "... (" + std::to_string(error.message.size()) + " bytes)";
    failure.error.message.resize(length);
  }
  return failure;
}

PeerTerms termsOf(const std::vector<std::string>& capabilities,
                  const std::vector<std::pair<std::string, std::uint64_t>>& limits) {
  PeerTerms terms;
  terms.takesBlocks = std::find(capabilities.begin(), capabilities.end(), "bin") != capabilities.end();
  terms.blockBytes = terms.takesBlocks ? terms.lineBytes : 0;
  for (const auto& [name, bound] : limits) {
    if (name == "lineBytes") {
      terms.lineBytes = bound;
    } else if (name == "blockBytes") {
      terms.blockBytes = bound;
    }
  }
  return terms;
}

}  // namespace espalier::server

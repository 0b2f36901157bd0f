#include "server/remote/environment_link.h"

#include <algorithm>

#include "protocol/json_text.h"

namespace espalier::server {

LinkFailure refusedWith(const protocol::Error& error) {
  constexpr std::size_t kMostBytes = 2000;
  LinkFailure failure{LinkFailure::Kind::Refused, "answered with an error: ", error};
  const std::string_view beginning = protocol::beginningOf(error.message, kMostBytes);
  failure.message += beginning;
  if (beginning.size() < error.message.size()) {
    failure.message += "... (" + std::to_string(error.message.size()) + " bytes)";
    failure.error.message.resize(beginning.size());
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

#include "server/remote/environment_link.h"

#include <algorithm>

namespace espalier::server {

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

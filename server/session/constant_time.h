#pragma once

#include <string_view>

namespace espalier::server {

/// Compares a secret. The duration does not depend on how much of `said` is right.
[[nodiscard]] inline bool isEqualInConstantTime(std::string_view said, std::string_view secret) {
  unsigned difference = said.size() == secret.size() ? 0 : 1;
  for (std::size_t i = 0; i < said.size(); ++i) {
    const unsigned char other = secret.empty() ? 0 : static_cast<unsigned char>(secret[i % secret.size()]);
    difference |= static_cast<unsigned>(static_cast<unsigned char>(said[i]) ^ other);
  }
  return difference == 0;
}

}  // namespace espalier::server

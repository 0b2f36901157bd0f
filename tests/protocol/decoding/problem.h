#pragma once

#include <string>

#include "protocol/codec.h"

namespace espalier::protocol {

/// The message of what was refused.
template <typename T>
[[nodiscard]] std::string problem(const Expected<T>& decoded) {
  return decoded ? "(accepted)" : decoded.error().message;
}

}  // namespace espalier::protocol

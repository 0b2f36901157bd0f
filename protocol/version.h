#pragma once

#include <cstdint>
#include <string_view>

namespace espalier::protocol {

/// The protocol's integer in the handshake. It rises only on a breaking change; everything else is a capability.
inline constexpr std::int64_t kProtocolVersion = 1;
inline constexpr std::string_view kProtocolName = "espalier/1";

/// The program's version, sent in the handshake for logs and people; never compared.
inline constexpr std::string_view kProgramVersion = "0.1.0";

/// Largest whole number that is exact in every JSON reader: 2^53.
inline constexpr std::int64_t kMaximumExactInteger = 9'007'199'254'740'992;

}  // namespace espalier::protocol

#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace espalier::protocol {

/// RFC 4648 base64 with padding: how snapshots and states cross the wire.
[[nodiscard]] std::string toBase64(std::string_view bytes);

/// The bytes, or nothing for anything that toBase64 would not have written.
[[nodiscard]] std::optional<std::string> fromBase64(std::string_view text);

}  // namespace espalier::protocol

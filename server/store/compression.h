#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace espalier::server {

/// Bytes compressed for the disk, with a checksum. States shrink to between a tenth and a hundredth, faster than the
/// disk would write the rest.
[[nodiscard]] std::string compress(std::string_view bytes);

/// The bytes again; nothing when they are cut off or damaged.
[[nodiscard]] std::optional<std::string> decompress(std::string_view packed);

}  // namespace espalier::server

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace espalier::server {

/// Compresses bytes for the disk, with a checksum. States shrink to between a tenth and a hundredth, faster than a disk
/// writes.
[[nodiscard]] std::string compress(std::string_view bytes);

/// The original bytes. Nothing when they are cut off, damaged or more than `maximumBytes`: a few bytes can stand for
/// gigabytes.
[[nodiscard]] std::optional<std::string> decompress(std::string_view packed, std::uint64_t maximumBytes = UINT64_MAX);

}  // namespace espalier::server

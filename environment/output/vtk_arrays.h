#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace espalier::environment {

/// Where the bytes of data arrays of a VTK file (XML, little-endian) are, and how they are packed.
struct VtkPacking {
  bool hasLongHeader = false;      // numbers before the data have 8 bytes, else 4
  bool isCompressed = false;       // by zlib, in blocks
  bool isAppendedBase64 = false;   // else appended data are raw
  std::string_view appended = {};  // data behind the `_` of AppendedData; the caller's
};

/// The bytes of base64, at most `most`. Blanks are skipped; padding ends a run, so that data written in several runs
/// are read as one. Nothing when the text is no base64; a tag ends it. O(most).
[[nodiscard]] std::optional<std::string> fromBase64Pieces(std::string_view text, std::size_t most);

/// The numbers of one array as bytes, without the header before them, from the beginning of `data`, which is base64 or
/// raw. At most `most` bytes are unpacked; an array that has more is an error, which is a sentence about the file
/// without its subject. O(data + most).
[[nodiscard]] tl::expected<std::string, std::string> unpackedBytes(std::string_view data, bool isBase64,
                                                                   const VtkPacking& packing, std::size_t most);

}  // namespace espalier::environment

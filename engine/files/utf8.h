#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace espalier::files {

/// The length of the UTF-8 sequence that begins a text, in bytes; 0 when the text is empty or not UTF-8 there.
[[nodiscard]] std::size_t sequenceLength(std::string_view text);

/// A text without the byte order mark that some editors put first.
[[nodiscard]] std::string_view withoutByteOrderMark(std::string_view text);

/// The same as UTF-8; a text that is not UTF-8 is read as Latin-1 (ISO 8859-1), the encoding of older files.
[[nodiscard]] std::string asUtf8(std::string_view text);

}  // namespace espalier::files

#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace espalier::language {

/// The bytes of the UTF-8 sequence that begins a text; 0: none does, or the text is empty.
[[nodiscard]] std::size_t sequenceLength(std::string_view text);

/// A text without the byte order mark that some editors put first.
[[nodiscard]] std::string_view withoutByteOrderMark(std::string_view text);

/// The same, and what is not UTF-8 is taken for Latin-1 (ISO 8859-1), the encoding of older files.
[[nodiscard]] std::string asUtf8(std::string_view text);

}  // namespace espalier::language

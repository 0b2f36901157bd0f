#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace espalier::files {

/// The length of the UTF-8 sequence that begins a text, in bytes; 0 when the text is empty or not UTF-8 there.
[[nodiscard]] std::size_t sequenceLength(std::string_view text);

/// A text without the byte order mark that some editors put first.
[[nodiscard]] std::string_view withoutByteOrderMark(std::string_view text);

/// The text of a file as the tools of today write it: UTF-16 with a byte order mark becomes UTF-8, byte order marks are
/// removed, a carriage return alone is a line end, and Ctrl-Z is the end of the file. Other bytes stay.
[[nodiscard]] std::string readableText(std::string_view bytes);

/// The same as UTF-8; a text that is not UTF-8 is read as Windows-1252, the encoding of older files, which holds
/// Latin-1 (ISO 8859-1).
[[nodiscard]] std::string asUtf8(std::string_view bytes);

/// The kind of a file that holds no model text, as in "a PNG picture"; empty: it may be text.
[[nodiscard]] std::string kindOfNoText(std::string_view bytes);

}  // namespace espalier::files

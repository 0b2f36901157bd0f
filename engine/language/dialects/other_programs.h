#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace espalier::language {

/// A file that is no model of a notation that Espalier reads.
struct ForeignFile {
  std::string message;  // says what the file is; empty: nothing is recognised
  std::string hint;
  std::size_t offset = 0;  // of the text that shows it
  std::size_t length = 1;
};

/// Recognises pictures, archives, documents and other files without text from the first bytes of a file.
[[nodiscard]] ForeignFile fileWithoutText(std::string_view bytes);

/// Recognises web pages, JSON, and models of programs whose language Espalier does not read: L+C, XL.
[[nodiscard]] ForeignFile modelOfOtherProgram(std::string_view text);

}  // namespace espalier::language

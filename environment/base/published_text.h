#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::environment {

/// One line `keyword: value` of a published environment file (`.e`) or specification file, with the data lines below.
struct PublishedLine {
  std::string keyword;            // before the separator, exactly as written
  std::string value;              // after it, without blanks at the ends
  core::SourceLocation location;  // of the keyword
  std::vector<std::string> data;  // further lines that begin with a number, as they are (an array's rows)
};

/// The character that ends the keyword of a line.
enum class PublishedSyntax : unsigned char {
  Specification,  // the first colon
  Environment,    // the first TAB or colon
};

/// The longest line, without its newline, that the published programs read.
inline constexpr std::size_t kLongestPublishedLine = 254;

/// Splits a file into its keyword lines and skips blank lines. A line that is too long is cut with a warning. A line
/// without a separator that does not begin with a number is ignored with a warning. O(text).
[[nodiscard]] std::vector<PublishedLine> readPublishedLines(const std::string& file, std::string_view text,
                                                            PublishedSyntax syntax,
                                                            std::vector<core::Diagnostic>& warnings);

/// Where the value of a line stands.
[[nodiscard]] core::SourceLocation valueLocation(const PublishedLine& line);

/// The numbers at the beginning of a text; separators are x , ; : blank and TAB. `rest` gets what follows the last one.
[[nodiscard]] std::vector<double> readPublishedNumbers(std::string_view text, std::string_view* rest = nullptr);

/// The words of a text, separated by blanks and TABs.
[[nodiscard]] std::vector<std::string> readPublishedWords(std::string_view text);

/// The path of a file that another file names: beside that file, unless the name is absolute.
[[nodiscard]] std::string besideFile(const std::string& file, const std::string& name);

}  // namespace espalier::environment

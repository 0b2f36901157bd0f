#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::environment {

/// One line `keyword: value` of a published environment file (`.e`) or specification file, with the data lines below.
/// The first TAB or colon ends the keyword.
struct PublishedLine {
  std::string keyword;                              // before the separator, exactly as written
  std::string value;                                // after it, without blanks at the ends
  core::SourceLocation location;                    // of the keyword
  std::vector<std::string> data;                    // further lines that begin with a number (an array's rows)
  std::vector<core::SourceLocation> dataLocations;  // of each of them
};

/// The longest line, without its newline, that the published programs read.
inline constexpr std::size_t kLongestPublishedLine = 254;

/// Splits a file into its keyword lines and skips blank lines. Every encoding of files::asUtf8 is accepted. A line that
/// is too long is cut with a warning. A line without a separator that does not begin with a number is ignored with a
/// warning. O(bytes).
[[nodiscard]] std::vector<PublishedLine> readPublishedLines(const std::string& file, std::string_view bytes,
                                                            std::vector<core::Diagnostic>& warnings);

/// Where the value of a line stands.
[[nodiscard]] core::SourceLocation valueLocation(const PublishedLine& line);

/// The characters between the values of a line.
inline constexpr std::string_view kPublishedSeparators = "x,;: \t\r";

/// Reads every word of a text as a number, as the published programs do: the longest number at its beginning, 0 when
/// there is none. So `100x100view` is 100 and 100, and `half` is 0. `areWhole` becomes false when something stands
/// behind the number of a word, or a word is no number.
[[nodiscard]] std::vector<double> readPublishedNumbers(std::string_view text, bool* areWhole = nullptr,
                                                       std::string_view separators = kPublishedSeparators);

/// The word of a switch: the first one of a line, empty when there is none.
[[nodiscard]] std::string_view firstPublishedWord(std::string_view text);

/// The words of a text, separated by blanks and TABs.
[[nodiscard]] std::vector<std::string> readPublishedWords(std::string_view text);

/// The path of a file that another file names: beside that file, unless the name is absolute.
[[nodiscard]] std::string besideFile(const std::string& file, const std::string& name);

}  // namespace espalier::environment

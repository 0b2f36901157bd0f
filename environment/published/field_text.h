#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::environment {

/// One line `keyword: value` of the field's environment (`.e`) and specification files, with the data lines below it.
struct FieldLine {
  std::string keyword;            // before the separator, exactly as written
  std::string value;              // after it, without blanks at the ends
  core::SourceLocation location;  // of the keyword
  std::vector<std::string> data;  // further lines that begin with a number, as they are (an array's rows)
};

/// What ends the keyword of a line.
enum class FieldSyntax : unsigned char {
  Specification,  // the first colon
  Environment,    // the first TAB or colon
};

/// The longest line, without its newline, that the field's programs read.
inline constexpr std::size_t kLongestFieldLine = 254;

/// Splits a file into its keyword lines. Blank lines are skipped; a longer line is cut with a warning; a line without
/// a separator that does not begin with a number is ignored with a warning. O(text).
[[nodiscard]] std::vector<FieldLine> readFieldLines(const std::string& file, std::string_view text, FieldSyntax syntax,
                                                    std::vector<core::Diagnostic>& warnings);

/// Where the value of a line stands.
[[nodiscard]] core::SourceLocation valueLocation(const FieldLine& line);

/// The numbers at the beginning of a text; separators are x , ; : blank and TAB. `rest` gets what follows the last one.
[[nodiscard]] std::vector<double> readFieldNumbers(std::string_view text, std::string_view* rest = nullptr);

/// The words of a text, separated by blanks and TABs.
[[nodiscard]] std::vector<std::string> readFieldWords(std::string_view text);

/// The name of a file that another file names: beside it, unless absolute.
[[nodiscard]] std::string besideFile(const std::string& file, const std::string& name);

}  // namespace espalier::environment

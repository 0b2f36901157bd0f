#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/language/dialects/lpy_expression.h"
#include "engine/language/dialects/text_lines.h"

namespace espalier::language {

/// A logical line of a Python text: comments removed, continuation lines joined.
struct PythonLine {
  std::size_t indent = 0;
  TextPiece code;  // without blanks at both ends; never empty
};

/// The logical lines of a text up to a line that begins with `###`. Comments and strings that stand alone are skipped.
[[nodiscard]] std::vector<PythonLine> pythonLines(std::string_view text);

/// Statements of a block: a line, and the blocks that belong to it.
struct PythonStatement {
  TextPiece code;  // without the final ':' of a compound statement
  std::vector<PythonStatement> body;
  bool isCompound = false;  // if, elif, else, for, while, def
};

/// The statements of lines [begin, end), which are indented alike or deeper. A statement behind the ':' of a compound
/// one is its body. Lines that are indented as Python forbids are errors.
[[nodiscard]] std::vector<PythonStatement> pythonBlock(const std::vector<PythonLine>& lines, std::size_t begin,
                                                       std::size_t end, DialectReport& report);

/// `name`, `=`, `+=`, ... and the value of an assignment.
struct PythonAssignment {
  std::string name;
  char operation = '=';  // '=' or the operator before it
  TextPiece value;
};
[[nodiscard]] std::optional<PythonAssignment> assignmentOf(const TextPiece& code);

/// The first word of a statement, and the text behind it.
[[nodiscard]] std::pair<std::string, TextPiece> firstWord(const TextPiece& code);

/// The values of a `for` with constant bounds: `i in range(3)`. Nothing, with an error, for other loops.
struct PythonLoop {
  std::string variable;
  std::vector<double> values;
};
[[nodiscard]] std::optional<PythonLoop> loopOf(const TextPiece& head, const LpyScope& scope, LpyDraws& draws,
                                               DialectReport& report);

}  // namespace espalier::language

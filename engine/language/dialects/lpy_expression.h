#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "engine/language/dialects/text_lines.h"
#include "engine/language/dialects/translation.h"

namespace espalier::language {

/// A value of a Python expression: its cpfg text, in parentheses where an operator could split it, and its number when
/// it is constant.
struct LpyValue {
  std::string text;
  std::optional<double> number;
};

/// The names that a Python expression may use.
struct LpyScope {
  std::map<std::string, LpyValue> values;        // constants, formal parameters and local variables
  std::set<std::string> variables;               // of the L-system: assigned in Start, StartEach, EndEach or End
  std::map<std::string, std::size_t> functions;  // the model's own functions, with the offsets of their definitions
};

/// Random draws of an expression that its text names by variables: `name = draw;` statements.
struct LpyDraws {
  bool areNamed = false;  // false: the draws stand in the text
  std::size_t count = 0;  // of names so far, in the whole model
  std::vector<std::string> statements;
};

/// Translates an expression of Python to cpfg: numbers, names, arithmetic, comparisons, `and or not`, `x if c else y`
/// and the functions of the modules math and random. Nothing, with an error in the report, for anything that needs
/// Python.
[[nodiscard]] std::optional<LpyValue> translateLpyExpression(const TextPiece& text, const LpyScope& scope,
                                                             LpyDraws& draws, DialectReport& report);

/// A name as cpfg reads it: names of cpfg's own, such as Q, get another letter in front.
[[nodiscard]] std::string lpyName(const std::string& name);

/// The value of a constant.
[[nodiscard]] LpyValue lpyConstant(double number);

/// The pieces between commas outside of brackets and strings.
[[nodiscard]] std::vector<TextPiece> lpyArguments(const TextPiece& list);

/// The hint of all messages about what needs Python.
inline constexpr std::string_view kNeedsPython =
    "write it with numbers only, or compute it with the Python package 'espalier'";

}  // namespace espalier::language

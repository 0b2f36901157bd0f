#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "engine/language/dialects/text_lines.h"
#include "engine/language/dialects/translation.h"

namespace espalier::language {

/// A subscript: a level of a recurrence, `n + shift` or the number `shift`, or a name.
struct Subscript {
  enum class Kind : std::uint8_t { None, Level, Number, Name };
  Kind kind = Kind::None;
  int shift = 0;
  std::string name;
};

/// The symbols that the modules of a textbook's model use.
struct TextbookSymbols {
  std::set<char> plain;                      // without parameter and subscript
  std::set<char> numbered;                   // with parameters
  std::set<char> all;                        // with or without
  std::set<std::string> names;               // with a name as subscript: F_a
  std::set<std::string> levelled;            // with a level as subscript
  std::set<std::string, std::less<>> words;  // textbookWords, set before modules are read
  bool hasLeaf = false;                      // the sign ♠
};

/// The additions of Turtle Painter to the notation.
struct PainterSigns {
  /// `%` as a value is a random whole number from 0 to 99, `t` the number of the step, and a turn with two parameters
  /// is by a random angle between them.
  bool areRead = false;
};

/// Translates strings of modules and expressions of the textbook notation to cpfg's.
class TextbookModules {
 public:
  TextbookModules(DialectReport& report, TextbookSymbols& symbols, PainterSigns painter)
      : report_(report), symbols_(symbols), painter_(painter) {}

  /// Constants of the model, by name, as cpfg text.
  void setConstants(std::map<std::string, std::string> constants) { constants_ = std::move(constants); }
  [[nodiscard]] bool isConstant(const std::string& name) const { return constants_.contains(name); }

  /// The names of a production's formal parameters: they hide `t`.
  void setFormals(const TextPiece& predecessor);

  /// A string of modules: blanks are removed, subscripts become names or parameters. In a successor levels are relative
  /// to the predecessor's, `n + predecessorShift`. A drawing has its rolls exchanged: those of strings are by drawings.
  [[nodiscard]] MappedText modules(const TextPiece& piece, int predecessorShift = 0, bool isDrawing = false);
  /// A condition or probability: `=` is `==`, `≤`, `≥`, `≠`, `∧` and `∨` are written out.
  [[nodiscard]] MappedText condition(const TextPiece& piece);
  /// Another expression: `∧` is a power.
  [[nodiscard]] MappedText expression(const TextPiece& piece);
  /// A symbol with a subscript that is a level or a number, alone: the predecessor of a recurrence.
  struct Levelled {
    std::string name;
    Subscript subscript;
  };
  [[nodiscard]] static std::optional<Levelled> levelled(const TextPiece& piece);

 private:
  void appendExpression(MappedText& result, const TextPiece& piece, bool isCondition) const;
  void appendParameters(MappedText& result, const TextPiece& piece, bool isTurn) const;

  DialectReport& report_;
  TextbookSymbols& symbols_;
  PainterSigns painter_;
  std::set<std::string> formals_;
  std::map<std::string, std::string> constants_;
};

/// The subscript at `at` of the text, which moves behind it.
[[nodiscard]] Subscript readSubscript(std::string_view text, std::size_t& at);

/// A number with a decimal point or comma, possibly a fraction, in per cent, or with a degree sign or a unit.
[[nodiscard]] std::optional<double> textbookNumber(std::string_view text);

}  // namespace espalier::language

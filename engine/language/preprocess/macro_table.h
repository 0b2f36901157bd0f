#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/limits.h"
#include "engine/files/source_map.h"

namespace espalier::language {

/// One #define, or a definition given by the caller.
struct Macro {
  std::string name;
  bool isFunctionLike = false;
  bool isFixed = false;                                 // an override: #define and #undef do not change it
  std::vector<std::string> parameters;                  // of a function-like macro
  std::string body;                                     // comments are blanks, no blanks at the ends
  std::uint32_t file = files::SourceMap::kNoExpansion;  // where it was defined; kNoExpansion: by the caller
  std::uint32_t offset = 0;                             // of its name there
};

/// A part of an expanded line.
struct ExpandedPiece {
  std::size_t begin = 0;  // bytes [begin, end) of the input it stands for
  std::size_t end = 0;
  const Macro* macro = nullptr;  // null: the input itself
  std::string text;              // replacement; empty for a copied piece
};

/// A mistake in an expansion: its place in the input, and a message with its hint.
struct ExpansionProblem {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::string message;
  std::string hint;
  bool isFatal = false;  // a limit was reached: the preprocessor stops
};

/// The macros of one preprocessor run and their expansion. Only whole identifiers are replaced, and never inside string
/// literals. Arguments are expanded first, and the result is scanned again. A macro is not expanded inside itself.
class MacroTable {
 public:
  explicit MacroTable(const core::Limits& limits) : limits_(limits) {}

  /// Adds or replaces a macro. False: the name is an override, and nothing was changed.
  bool define(Macro macro);
  void undefine(std::string_view name);
  [[nodiscard]] std::vector<std::string> names() const;
  [[nodiscard]] const Macro* find(std::string_view name) const;
  /// Whether a macro is called in `line` and the line ends inside its arguments. O(length).
  [[nodiscard]] bool hasOpenCall(std::string_view line) const;
  /// So much text of the model was read: its macros may expand to a megabyte and a hundred times as much, within
  /// maximumSourceBytes. Without that, a model of 300 bytes costs what 64 MB cost.
  void addText(std::uint64_t bytes) { textBytes_ += bytes; }

  /// The pieces of `line` in order; `problem` is called for each mistake (the use is then copied as it is).
  [[nodiscard]] std::vector<ExpandedPiece> expand(std::string_view line,
                                                  const std::function<void(const ExpansionProblem&)>& problem);

 private:
  class Expansion;

  core::Limits limits_;
  std::map<std::string, Macro, std::less<>> macros_;
  std::uint64_t textBytes_ = 0;
  std::uint64_t expandedBytes_ = 0;  // bytes scanned in all expansions so far
};

[[nodiscard]] constexpr bool isIdentifierStart(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
}
[[nodiscard]] constexpr bool isDigit(char c) {
  return c >= '0' && c <= '9';
}
[[nodiscard]] constexpr bool isIdentifierPart(char c) {
  return isIdentifierStart(c) || isDigit(c);
}
/// Letters of a word of the preprocessor: it counts `$` among the letters.
[[nodiscard]] constexpr bool isWordStart(char c) {
  return isIdentifierStart(c) || c == '$';
}
[[nodiscard]] constexpr bool isWordPart(char c) {
  return isWordStart(c) || isDigit(c);
}
[[nodiscard]] constexpr bool isBlank(char c) {
  return c == ' ' || c == '\t';
}

/// The end of the string literal that opens at `begin`, after its closing quote; `begin` itself when the line has none,
/// so that a quote used as a symbol begins no string.
[[nodiscard]] std::size_t stringLiteralEnd(std::string_view line, std::size_t begin);

/// Finds the string literals of one line from left to right. Together the calls take time in proportion to the line.
class StringLiterals {
 public:
  /// `line` must outlive the object.
  explicit StringLiterals(std::string_view line) : line_(line) {}

  /// stringLiteralEnd of the line. `begin` must not lie before that of an earlier call.
  [[nodiscard]] std::size_t endOf(std::size_t begin) {
    // where one quote has no partner, those behind it have none either: all of them are escaped
    const std::size_t end = isOpen_ ? begin : stringLiteralEnd(line_, begin);
    isOpen_ = end == begin;
    return end;
  }

 private:
  std::string_view line_;
  bool isOpen_ = false;
};

/// The end of the word of the preprocessor, a name or a number, that starts at `begin`; `begin` when there is none.
[[nodiscard]] std::size_t wordEnd(std::string_view line, std::size_t begin);

[[nodiscard]] std::string_view trimBlanks(std::string_view text);

}  // namespace espalier::language

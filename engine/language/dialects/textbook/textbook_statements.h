#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/language/dialects/text_lines.h"

namespace espalier::language {

/// Place and length of the first arrow.
[[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> arrowOf(std::string_view text);

/// The statements of a plain text: lines. A line that begins with an arrow, and a rest of a successor that is indented,
/// begins with a sign or stands in an open bracket, belong to the line before. `n=5, δ=25.7°` is two statements.
/// `remarks` receives the places of all remarks: one between the lines of a statement stands in its text.
[[nodiscard]] std::vector<TextPiece> textbookStatements(std::string_view text,
                                                        std::vector<TextPiece>* remarks = nullptr);

enum class Setting : std::uint8_t { Axiom, Angle, Steps, Heading, Step, Turns, Productions, Ignore, Consider, Sets };

struct NamedValue {
  Setting setting = Setting::Sets;
  std::string name;  // small letters
  TextPiece value;
};

/// `name: value` or `name = value` of a known name, or `name value` of a long one.
[[nodiscard]] std::optional<NamedValue> settingOf(const TextPiece& statement);
/// The known name nearest to a misspelt one; empty: none is near.
[[nodiscard]] std::string_view nearestSetting(std::string_view name);

/// The first axiom of a text.
[[nodiscard]] std::optional<NamedValue> axiomOf(std::string_view text);
/// The axioms of a set `L,R`.
[[nodiscard]] std::vector<TextPiece> axiomsOf(TextPiece value);

/// A production without its label `p1:`, `P2 =`, `Rule 3:` or `4)`.
[[nodiscard]] TextPiece withoutLabel(const TextPiece& statement);

/// A predecessor without contexts `* <` and `> *`, which match anything.
[[nodiscard]] TextPiece withoutAnyContext(TextPiece predecessor);

/// The parts of `F → FF, X → F`, `{...}` or `(...), (...)` that hold one production each.
[[nodiscard]] std::vector<TextPiece> productionsOf(TextPiece value);

/// Constants beside productions, `R = 0.7` and `#define R 0.7`: names of expressions, with their values as cpfg text.
/// Only names that an expression of the model uses.
[[nodiscard]] std::map<std::string, std::string> textbookConstants(const std::vector<TextPiece>& statements);

/// A name of an expression at `at`, which moves behind it: letters, digits and subscripts, `r₁`, `r_1`, `α`. Greek
/// letters are written out and underscores removed. Empty: none begins there.
[[nodiscard]] std::string readTextbookName(std::string_view text, std::size_t& at);

}  // namespace espalier::language

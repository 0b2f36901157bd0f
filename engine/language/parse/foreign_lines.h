#pragma once

#include <string>
#include <string_view>

namespace espalier::language {

/// A word at the beginning of a line that means something in other programs or in papers, and the advice for it.
struct ForeignLine {
  std::string word;    // as messages show it
  std::string advice;  // empty: the line is none of those that are known
  bool isAxiom = false;
};

/// The habit of another program in a line without an arrow: a heading such as `production:`, a setting such as
/// `angle: 30`, a constant of a program, a remark, a command of LaTeX.
[[nodiscard]] ForeignLine foreignLine(std::string_view line);

/// The name of the command of LaTeX at the beginning of `text`, with its backslash, such as `\omega`. Empty: none of
/// those that papers about L-systems use.
[[nodiscard]] std::string_view latexCommand(std::string_view text);
/// What to write in its place.
[[nodiscard]] std::string latexAdvice(std::string_view command);

/// Advice when a predecessor is the label of a production, as in `p1: A --> AB`. Empty: it is none.
[[nodiscard]] std::string labelAdvice(std::string_view predecessor);

}  // namespace espalier::language

#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "engine/language/dialects/text_lines.h"

namespace espalier::language {

/// The symbols of a model that are words: `plant → internode [leaf]`. A word has three letters or more, one of them
/// small. A model has words when one of them is a predecessor; the other words of its productions are symbols then,
/// too. Empty: every letter is a symbol.
[[nodiscard]] std::set<std::string, std::less<>> textbookWords(const std::vector<TextPiece>& statements);

/// The longest of these words with which a text begins; empty: none.
[[nodiscard]] std::string_view wordAt(std::string_view text, const std::set<std::string, std::less<>>& words);

/// The words in the predecessors of a model. They are views of the text.
[[nodiscard]] std::set<std::string_view> wordsOfPredecessors(std::string_view text);

/// Whether the text behind two slashes in a production is a remark, and not modules behind two rolls. Predecessors may
/// be words.
[[nodiscard]] bool isRemark(std::string_view behindSlashes, const std::set<std::string_view>& predecessors);

/// The angle in `The parameter δ is 22°.`
[[nodiscard]] std::optional<double> angleOfSentence(std::string_view text);

/// Words with blanks between them: a title or a remark.
[[nodiscard]] bool isProse(std::string_view text);

/// The place of the colon, semicolon or comma before the condition in the left side of a production; npos: it has none.
[[nodiscard]] std::size_t conditionMark(std::string_view left);

/// Takes the probability off the left side of a production: `F .5`, `F (0.5)`, `F : 0.5`, and `F -(0.5)` or `F -0.5`
/// when it is joined to the arrow. Returns its number; empty: there is none.
[[nodiscard]] TextPiece takeProbability(TextPiece& left, bool isJoined);

/// The same at the beginning of a successor: `.5 F[+F]F`.
[[nodiscard]] TextPiece takeFrontProbability(TextPiece& right);

/// The same at the end of a successor: `F[+F]F 50%`.
[[nodiscard]] TextPiece takeEndProbability(TextPiece& right);

/// Writes a colon for the word before a condition: `A(x) where x<3 → F`, also `if` and `when`.
void markConditions(std::string& text);

/// Advice about a line of a preprocessor, which these notations do not have: `directive` is the text behind '#'. Empty:
/// it is none.
[[nodiscard]] std::string directiveAdvice(std::string_view directive, std::string_view text);

}  // namespace espalier::language

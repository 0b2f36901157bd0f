#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/language/parse/symbol_table.h"

namespace espalier::language {

enum class TokenKind : std::uint8_t {
  EndOfFile,
  EndOfLine,  // of an item or production; in free syntax also `;`
  Keyword,
  // symbol mode
  Symbol,
  LeftContext,      // <
  RightContext,     // >
  NewLeftContext,   // <<
  NewRightContext,  // >>
  Colon,            // also in expression mode
  Star,             // also in expression mode
  Arrow,            // --> also in expression mode
  InstanceArrow,    // -o> also in expression mode
  OpenParenthesis,  // also in expression mode
  // expression mode
  CloseParenthesis,
  Number,
  Identifier,
  String,
  Operator,  // one of the operators of expressions, by its text
  Assign,
  Ampersand,
  Question,
  Comma,
  Semicolon,
  OpenBrace,
  CloseBrace,
  OpenBracket,
  CloseBracket,
  // not a token; `text` is the reason
  Invalid,
};

enum class Keyword : std::uint8_t {
  Lsystem,
  Seed,
  DerivationLength,
  MaximumDepth,
  Consider,
  Ignore,
  Axiom,
  Define,
  Ring,
  Start,
  End,
  StartEach,
  EndEach,
  Homomorphism,
  Decomposition,
  Warnings,
  NoWarnings,
  Endlsystem,
  Module,  // Espalier: named modules
  Syntax,  // Espalier: `Syntax: free`
};

struct Token {
  TokenKind kind = TokenKind::EndOfFile;
  Keyword keyword = Keyword::Lsystem;
  core::SymbolId symbol = core::kNoSymbol;
  double number = 0.0;
  std::string text;  // of strings with escapes replaced; of the source otherwise
  std::string hint;  // Invalid
  core::SourceRange range;
};

/// Cuts preprocessed text into tokens on demand. The parser chooses the mode for each token: in symbol mode every
/// character (or declared name) is a module's name, in expression mode the text is like C.
class Lexer {
 public:
  /// `text` and `symbols` must outlive the lexer.
  Lexer(std::string_view text, SymbolTable& symbols) : text_(text), symbols_(symbols) {}

  /// The next token without consuming it.
  [[nodiscard]] const Token& peekSymbol() { return peek(Mode::Symbol); }
  [[nodiscard]] const Token& peekExpression() { return peek(Mode::Expression); }

  /// Whether characters without a meaning were skipped before the token peeked last.
  [[nodiscard]] bool skipsBeforeToken() const { return !skipping_.empty(); }
  [[nodiscard]] const core::SourceRange& skippedBeforeToken() const { return skipping_.back(); }
  /// The characters of expressions that begin no token, up to the token consumed last. They are skipped like blanks;
  /// neighbours are one range.
  [[nodiscard]] const std::vector<core::SourceRange>& skipped() const { return skipped_; }

  /// Whether exactly `...` was skipped before the token peeked last: the dots then count as read.
  [[nodiscard]] bool takeDots();

  /// Consumes the token peeked last.
  void advance();

  /// The keyword that starts at the next non-blank, or none (EndOfFile).
  [[nodiscard]] Token peekKeyword();

  /// One character of an `ignore:` or `consider:` list, a declared name, or EndOfLine; no character is special there.
  [[nodiscard]] const Token& peekPlain() { return peek(Mode::Plain); }

  /// Inside `{...}` newlines are blanks.
  void enterBlock() { setNesting(blockDepth_ + 1); }
  void leaveBlock() { setNesting(blockDepth_ > 0 ? blockDepth_ - 1 : 0); }
  [[nodiscard]] std::uint32_t blockDepth() const { return blockDepth_; }
  void setNesting(std::uint32_t depth);

  /// In free syntax newlines inside `(...)` and `[...]` are blanks, too.
  void setBracketDepth(std::uint32_t depth);
  [[nodiscard]] std::uint32_t bracketDepth() const { return bracketDepth_; }

  void setFreeSyntax(bool isFree);
  [[nodiscard]] bool isFreeSyntax() const { return isFree_; }

  [[nodiscard]] std::uint32_t position() const { return position_; }
  [[nodiscard]] std::string_view text() const { return text_; }

  /// Moves behind the end of the current item or production, out of all blocks. In a block it stops before a line
  /// that starts with a keyword.
  void skipLine();

  /// Skips lines that start with a blank other than TAB, up to the first other line.
  void skipIndentedLines();

  /// Whether the current line, or the next line when the current one has ended, starts with blanks although only a TAB
  /// would continue the previous line.
  [[nodiscard]] bool nextLineIsIndented() const;

  /// Whether the line that holds `position` starts with blanks instead of a TAB.
  [[nodiscard]] bool lineIsIndented(std::uint32_t position) const;

 private:
  enum class Mode : std::uint8_t { None, Symbol, Expression, Plain };

  const Token& peek(Mode mode);
  Token scanSymbol();
  Token scanExpression();
  Token scanPlain();
  [[nodiscard]] std::uint32_t skipBlanks(std::uint32_t position) const;
  std::uint32_t skipMeaningless(std::uint32_t position);
  [[nodiscard]] bool newlineEnds(std::uint32_t newline) const;
  [[nodiscard]] bool matchKeyword(std::uint32_t position, Token& token) const;
  [[nodiscard]] Token number(std::uint32_t begin) const;
  [[nodiscard]] Token string(std::uint32_t begin) const;
  [[nodiscard]] Token make(TokenKind kind, std::uint32_t begin, std::uint32_t end) const;
  [[nodiscard]] Token invalidCharacter(std::uint32_t begin) const;
  [[nodiscard]] char at(std::uint32_t position) const { return position < text_.size() ? text_[position] : '\0'; }

  std::string_view text_;
  SymbolTable& symbols_;
  std::uint32_t position_ = 0;
  std::uint32_t blockDepth_ = 0;
  std::uint32_t bracketDepth_ = 0;
  bool isFree_ = false;
  Mode peekedMode_ = Mode::None;
  Token peeked_;
  std::vector<core::SourceRange> skipping_;  // characters skipped before peeked_
  std::vector<core::SourceRange> skipped_;   // before the tokens consumed
};

/// The words of a message for a token: 'x', the number 12, the end of the line, ...
[[nodiscard]] std::string describe(const Token& token);

}  // namespace espalier::language

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "engine/language/decimal_comma.h"
#include "engine/language/hexadecimal.h"
#include "engine/language/parse/foreign_lines.h"
#include "engine/language/parse/parser.h"
#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

// characters that editors put in the place of ASCII characters, and the advice for each
constexpr std::array<std::pair<std::string_view, std::string_view>, 21> kLookalikes{{
    {"\xE2\x89\xA4", "write '<='"},
    {"\xE2\x89\xA5", "write '>='"},
    {"\xE2\x89\xA0", "write '!='"},
    {"\xC3\x97", "write '*' for a product"},
    {"\xC2\xB7", "write '*' for a product"},
    {"\xC3\xB7", "write '/' for a quotient"},
    {"\xE2\x88\x92", "write the minus sign of the keyboard, '-'"},
    {"\xE2\x80\x93", "an editor has joined two hyphens into a dash: write the arrow as '-->'"},
    {"\xE2\x80\x94", "an editor has joined two hyphens into a dash: write the arrow as '-->'"},
    {"\xE2\x86\x92", "write the arrow as '-->'"},
    {"\xE2\x80\x9C", "write the straight quote of the keyboard, '\"'"},
    {"\xE2\x80\x9D", "write the straight quote of the keyboard, '\"'"},
    {"\xE2\x80\x98", "write the straight quote of the keyboard"},
    {"\xE2\x80\x99", "write the straight quote of the keyboard"},
    {"\xC2\xB0", "angles are always in degrees: remove the sign"},
    {"\xC2\xA0", "this is a no-break space, which looks like a blank: type the blank again"},
    {"\xE2\x80\x8B", "this is an invisible character, a blank of width 0: delete it"},
    {"\xC2\xB2", "write the square as '^2'"},
    {"\xC2\xB3", "write the cube as '^3'"},
    {"\xCF\x80", "write pi"},
    {"\xEF\xBB\xBF", "the file starts with a byte order mark: save it as plain text without one"},
}};

}  // namespace

/// Reports a line with the habit of another program, and skips it. The result has no advice when the line is none.
ForeignLine Parser::skipForeignLine(std::string_view what, const Token& token) {
  const ForeignLine foreign = foreignLine(lineAt(token.range.begin));
  if (foreign.advice.empty()) {
    return foreign;
  }
  Token word = token;
  word.kind = TokenKind::Symbol;
  word.text = foreign.word;
  word.range.end = token.range.begin + static_cast<std::uint32_t>(foreign.word.size());
  expected(what, word, foreign.advice);
  recover();
  return foreign;
}

std::string_view Parser::lineAt(std::uint32_t position) const {
  const std::string_view rest = lexer_.text().substr(position);
  return rest.substr(0, rest.find('\n'));
}

/// Whether the line that holds `position` begins inside a comment.
bool Parser::startsInComment(std::uint32_t position) const {
  const std::size_t newline = position == 0 ? std::string_view::npos : lexer_.text().rfind('\n', position - 1);
  return newline != std::string_view::npos && std::ranges::binary_search(commentNewlines_, newline);
}

/// Advice when the line that holds `position` was probably meant to continue the line before. Empty: it was not.
std::string Parser::continuationHint(std::uint32_t position) const {
  if (startsInComment(position)) {
    return "a comment over several lines ends a production or item: write it on one line, or above";
  }
  if (!lexer_.isFreeSyntax() && lexer_.lineIsIndented(position)) {
    return "a continuation line must start with a TAB, not with blanks (or write 'Syntax: free' before the first "
           "L-system)";
  }
  return {};
}

/// Advice about an unusable token, by the habit that led to it. Empty: no special advice.
std::string Parser::adviceFor(const Token& token) const {
  const char before = token.range.begin > 0 ? lexer_.text()[token.range.begin - 1] : '\n';
  if ((token.kind == TokenKind::Arrow || token.kind == TokenKind::Keyword) && !lexer_.isFreeSyntax()) {
    const std::size_t newline =
        token.range.begin == 0 ? std::string_view::npos : lexer_.text().rfind('\n', token.range.begin - 1);
    if (newline != std::string_view::npos && lexer_.text()[newline + 1] == '\t') {
      return "this line starts with a TAB and therefore continues the previous line; start it in column 1";
    }
  }
  switch (token.kind) {
    case TokenKind::Invalid:
      if (!token.hint.empty()) {
        return token.hint;
      }
      if (token.text.starts_with("\xE2\x80") && static_cast<unsigned char>(token.text.back()) >= 0x98U &&
          std::string_view("(,").find(before) == std::string_view::npos &&
          (reading_ == "the axiom" || reading_ == "the successor")) {
        return "modules are written without quotes";
      }
      for (const auto& [character, advice] : kLookalikes) {
        if (token.text == character) {
          return std::string(advice);
        }
      }
      return token.text.empty() || static_cast<unsigned char>(token.text[0]) < 0x80U
                 ? std::string()
                 : "models are written in 7-bit ASCII; other characters may stand in comments and strings only";
    case TokenKind::Star:
      return before == '*' ? "the power is written with '^', as in x^2" : std::string();
    case TokenKind::Colon:
      return colonAdvice(token);
    case TokenKind::OpenParenthesis:
      return reading_ == "a production" ? "a probability stands at the end of a production: A --> B : 0.5"
                                        : std::string();
    case TokenKind::CloseParenthesis:
      return reading_ == "a production" && isDigit(before) && isDigit(lexer_.text()[productionBegin_])
                 ? "productions have no numbers: remove '" +
                       std::string(lexer_.text().substr(productionBegin_, token.range.end - productionBegin_)) + "'"
             : reading_ == "a production" ? "no '(' is open here"
                                          : std::string();
    case TokenKind::Semicolon:
      return reading_.ends_with(":'") && reading_ != "'define:'" ? "no ';' stands at the end of the line"
                                                                 : std::string();
    case TokenKind::LeftContext:
    case TokenKind::RightContext:
      return reading_ == "the successor" ? "a condition stands before the arrow, as in A(x) : x > 1 --> B"
                                         : std::string();
    case TokenKind::Assign:
      if (reading_ == "the successor" || reading_ == "the axiom") {
        return before == 'p' ? "a probability stands at the end of a production: A --> B : 0.5"
                             : "a module has only values, as A(1); its productions name them, as A(x) --> B(x)";
      }
      if (before == ':') {
        return "the arrow of a production is '-->'";
      }
      if (std::string_view("+-*/").find(before) != std::string_view::npos) {
        return "there is no '" + std::string(1, before) + "=': write n = n " + std::string(1, before) + " 1";
      }
      return lexer_.text().substr(token.range.begin).starts_with("=>") ? "did you mean '>='?"
             : reading_ == "the condition"                             ? "'==' compares; '=' assigns, in blocks only"
                                                                       : std::string();
    case TokenKind::Operator:
      if (token.text == ">" && before == '-') {
        return "the arrow of a production has two strokes: '-->'";
      }
      return token.text == "+" && before == '+' ? "there is no '++': write n = n + 1" : std::string();
    case TokenKind::Identifier:
      if (std::string hint = hexadecimalHint(lexer_.text(), token.range.begin); !hint.empty()) {
        return hint;
      }
      return token.text == "and"                                ? "write '&&'"
             : token.text == "or"                               ? "write '||'"
             : token.text == "not"                              ? "write '!'"
             : token.text == "is"                               ? "write '=='"
             : token.text == "mod"                              ? "the remainder of a division is written as x % 2"
             : token.text == "if" && reading_ == "a production" ? "a condition follows ':', as in A(x) : x > 1 --> B"
             : token.text == "if" && reading_ == "the condition"
                 ? "the condition stands without the word 'if', as in A(x) : x > 1 --> B"
             : token.text == "else" && reading_ == "the condition"
                 ? "write the production for all other cases below, without a condition: the first that matches applies"
                 : std::string();
    case TokenKind::Comma:
      return decimalCommaHint(lexer_.text(), token.range.begin);
    case TokenKind::EndOfLine:
      return before == '%' ? "'%' is the remainder of a division; 50% is 0.5" : std::string();
    default:
      return {};
  }
}

/// Warns when the module '\\' at `begin` and the letters behind it are a command of LaTeX.
void Parser::warnAboutLatex(std::uint32_t begin) {
  const std::string_view command = latexCommand(lexer_.text().substr(begin));
  if (!command.empty()) {
    messages_.warning({begin, begin + static_cast<std::uint32_t>(command.size())},
                      "'" + std::string(command) + "' is read as " + std::to_string(command.size()) +
                          " modules: '\\' and its letters",
                      latexAdvice(command));
  }
}

/// Advice about a colon in the place of an arrow.
std::string Parser::colonAdvice(const Token& token) const {
  const std::string_view head = lexer_.text().substr(predecessor_.begin, predecessor_.end - predecessor_.begin);
  if (std::string advice = labelAdvice(head); !advice.empty()) {
    return advice;
  }
  if (reading_ != "the condition") {
    return {};
  }
  return token.range.begin > 0 && lexer_.text()[token.range.begin - 1] == ':'
             ? "one ':' stands before the condition"
             : "a probability stands at the end of a production: A --> B : 0.5";
}

/// Warns about the characters in expressions that the lexer skipped.
void Parser::reportSkippedCharacters() {
  for (const core::SourceRange& range : lexer_.skipped()) {
    const std::string text(lexer_.text().substr(range.begin, range.end - range.begin));
    const bool isOne = text.size() == 1;
    const std::string_view rest = lexer_.text().substr(range.begin);
    const bool begins = range.end < lexer_.text().size() && isIdentifierStart(lexer_.text()[range.end]);
    messages_.warning(range,
                      std::string(isOne ? "the character '" : "the characters '") + text + "' " +
                          (isOne ? "has no meaning in expressions and is" : "have no meaning in expressions and are") +
                          " skipped",
                      text == "|"                    ? "write '||' for 'or'"
                      : !latexCommand(rest).empty()  ? latexAdvice(latexCommand(rest))
                      : text.back() == '_' && begins ? "a name begins with a letter"
                      : isOne                        ? "remove it"
                                                     : "remove them");
  }
}

/// Advice about a parenthesis that was opened at `open` and is not closed at `found`.
std::string Parser::unclosedHint(core::SourceRange open, const Token& found) const {
  switch (found.kind) {
    case TokenKind::Identifier:
    case TokenKind::Number:
    case TokenKind::OpenParenthesis:
    case TokenKind::OpenBracket:
    case TokenKind::Arrow:
    case TokenKind::EndOfLine:
    case TokenKind::EndOfFile:
      break;
    default:
      return {};
  }
  // the text from the character before the parenthesis shows which parenthesis it is
  const std::uint32_t begin = open.begin > 0 && lexer_.text()[open.begin - 1] != '\n' ? open.begin - 1 : open.begin;
  const std::uint32_t end = std::min(found.range.begin, begin + 30);
  const bool isValue = found.kind == TokenKind::Identifier || found.kind == TokenKind::Number;
  return "a ')' for '" + foldBlanks(lexer_.text().substr(begin, end - begin)) + "' is missing" +
         (found.kind == TokenKind::OpenParenthesis ? ", or a '*' before this '('"
          : isValue                                ? ", or an operator or a comma before this"
                                                   : "");
}

}  // namespace espalier::language

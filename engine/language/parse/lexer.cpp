#include "engine/language/parse/lexer.h"

#include <algorithm>
#include <array>

#include "engine/core/number_text.h"
#include "engine/language/preprocess/macro_table.h"
#include "engine/language/world_names.h"

namespace espalier::language {
namespace {

struct KeywordText {
  Keyword keyword;
  // the first letter in lower case; a blank matches one blank or more, '~' any number of blanks
  std::string_view pattern;
  bool onlyAtLineStart;
};

// longer spellings first
constexpr std::array<KeywordText, 22> kKeywords{{{Keyword::DerivationLength, "derivation~length:", false},
                                                 {Keyword::MaximumDepth, "maximum depth:", false},
                                                 {Keyword::Homomorphism, "homomorphism:", false},
                                                 {Keyword::Homomorphism, "homomorphism", false},
                                                 {Keyword::Decomposition, "decomposition:", false},
                                                 {Keyword::Decomposition, "decomposition", false},
                                                 {Keyword::StartEach, "start~each:", false},
                                                 {Keyword::StartEach, "start~Each:", false},
                                                 {Keyword::EndEach, "end~each:", false},
                                                 {Keyword::EndEach, "end~Each:", false},
                                                 {Keyword::Endlsystem, "endlsystem", false},
                                                 {Keyword::NoWarnings, "no warnings", false},
                                                 {Keyword::Ring, "ring Lsystem", false},
                                                 {Keyword::Ring, "ring lsystem", false},
                                                 {Keyword::Lsystem, "lsystem:", false},
                                                 {Keyword::Consider, "consider:", false},
                                                 {Keyword::Ignore, "ignore:", false},
                                                 {Keyword::Define, "define:", false},
                                                 {Keyword::Warnings, "warnings", false},
                                                 {Keyword::Axiom, "axiom:", false},
                                                 {Keyword::Start, "start:", false},
                                                 {Keyword::End, "end:", false}}};
constexpr std::array<KeywordText, 3> kLineKeywords{
    {{Keyword::Seed, "seed:", false}, {Keyword::Module, "module:", true}, {Keyword::Syntax, "syntax:", true}}};

/// Whether `c` begins no token of an expression, with `next` behind it.
constexpr bool isMeaningless(char c, char next) {
  switch (c) {
    case '|':
      return next != '|';
    case '.':
      return !isDigit(next);
    default:
      return std::string_view("\\@#$~'`_").find(c) != std::string_view::npos;
  }
}

constexpr char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

// the length of the pattern's text at the start of `text`; 0 when it does not match
std::size_t matchPattern(std::string_view text, std::string_view pattern) {
  std::size_t length = 0;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] == ' ' || pattern[i] == '~') {
      const std::size_t begin = length;
      while (length < text.size() && isBlank(text[length])) {
        ++length;
      }
      if (pattern[i] == ' ' && length == begin) {
        return 0;
      }
    } else if (length < text.size() && (i == 0 ? lower(text[length]) : text[length]) == pattern[i]) {
      ++length;
    } else {
      return 0;
    }
  }
  return length;
}

}  // namespace

bool Lexer::matchKeyword(std::uint32_t position, Token& token) const {
  // most characters start no keyword
  constexpr std::string_view kFirstLetters = "adceilmnrshw";
  if (kFirstLetters.find(lower(at(position))) == std::string_view::npos) {
    return false;
  }
  const std::string_view rest = text_.substr(position);
  const bool isAtLineStart = [&] {
    std::uint32_t i = position;
    while (i > 0 && isBlank(text_[i - 1])) {
      --i;
    }
    return i == 0 || text_[i - 1] == '\n';
  }();
  const auto accept = [&](const KeywordText& candidate) {
    const std::size_t length = matchPattern(rest, candidate.pattern);
    if (length == 0 || (candidate.onlyAtLineStart && !isAtLineStart)) {
      return false;
    }
    token = make(TokenKind::Keyword, position, position + static_cast<std::uint32_t>(length));
    token.keyword = candidate.keyword;
    return true;
  };
  return std::any_of(kKeywords.begin(), kKeywords.end(), accept) ||
         std::any_of(kLineKeywords.begin(), kLineKeywords.end(), accept);
}

Token Lexer::make(TokenKind kind, std::uint32_t begin, std::uint32_t end) const {
  Token token;
  token.kind = kind;
  token.text = text_.substr(begin, end - begin);
  token.range = {begin, end};
  return token;
}

const Token& Lexer::peek(Mode mode) {
  if (peekedMode_ != mode) {
    skipping_.clear();
    peeked_ = mode == Mode::Symbol ? scanSymbol() : mode == Mode::Expression ? scanExpression() : scanPlain();
    peekedMode_ = mode;
  }
  return peeked_;
}

bool Lexer::takeDots() {
  if (skipping_.size() != 1 || text_.substr(skipping_[0].begin, skipping_[0].end - skipping_[0].begin) != "...") {
    return false;
  }
  skipping_.clear();
  return true;
}

void Lexer::advance() {
  if (peekedMode_ != Mode::None) {
    position_ = peeked_.range.end;
    peekedMode_ = Mode::None;
    skipped_.insert(skipped_.end(), skipping_.begin(), skipping_.end());
  }
}

Token Lexer::peekKeyword() {
  Token token;
  token.range = {position_, position_};
  (void)matchKeyword(skipBlanks(position_), token);
  return token;
}

void Lexer::setNesting(std::uint32_t depth) {
  blockDepth_ = depth;
  peekedMode_ = Mode::None;
}

void Lexer::setBracketDepth(std::uint32_t depth) {
  bracketDepth_ = depth;
  peekedMode_ = Mode::None;
}

void Lexer::setFreeSyntax(bool isFree) {
  isFree_ = isFree;
  peekedMode_ = Mode::None;
}

bool Lexer::newlineEnds(std::uint32_t newline) const {
  if (blockDepth_ > 0) {
    return false;
  }
  if (!isFree_) {
    return at(newline + 1) != '\t';
  }
  if (bracketDepth_ > 0) {
    return false;
  }
  // blank lines do not count
  std::uint32_t position = newline + 1;
  std::uint32_t lineBegin = position;
  while (position < text_.size() && (isBlank(text_[position]) || text_[position] == '\n')) {
    lineBegin = text_[position] == '\n' ? position + 1 : lineBegin;
    ++position;
  }
  return position >= text_.size() || position == lineBegin;
}

std::uint32_t Lexer::skipBlanks(std::uint32_t position) const {
  while (position < text_.size() && (isBlank(text_[position]) || (text_[position] == '\n' && !newlineEnds(position)))) {
    ++position;
  }
  return position;
}

std::uint32_t Lexer::skipMeaningless(std::uint32_t position) {
  position = skipBlanks(position);
  while (position < text_.size() && isMeaningless(text_[position], at(position + 1))) {
    if (!skipping_.empty() && skipping_.back().end == position) {
      ++skipping_.back().end;
    } else {
      skipping_.push_back({position, position + 1});
    }
    position = skipBlanks(position + 1);
  }
  return position;
}

Token Lexer::invalidCharacter(std::uint32_t begin) const {
  // a whole UTF-8 sequence is one wrong character
  std::uint32_t end = begin + 1;
  while ((static_cast<unsigned char>(at(end)) & 0xC0U) == 0x80U) {
    ++end;
  }
  return make(TokenKind::Invalid, begin, end);
}

Token Lexer::scanSymbol() {
  const std::uint32_t begin = skipBlanks(position_);
  if (begin >= text_.size()) {
    return make(TokenKind::EndOfFile, begin, begin);
  }
  const char c = text_[begin];
  const std::string_view rest = text_.substr(begin);
  if (c == '\n') {
    return make(TokenKind::EndOfLine, begin, begin + 1);
  }
  if (rest.starts_with("-->")) {
    return make(TokenKind::Arrow, begin, begin + 3);
  }
  if (rest.starts_with("-o>")) {
    return make(TokenKind::InstanceArrow, begin, begin + 3);
  }
  Token keyword;
  if (matchKeyword(begin, keyword)) {
    return keyword;
  }
  switch (c) {
    case '<':
      return rest.starts_with("<<") ? make(TokenKind::NewLeftContext, begin, begin + 2)
                                    : make(TokenKind::LeftContext, begin, begin + 1);
    case '>':
      return rest.starts_with(">>") ? make(TokenKind::NewRightContext, begin, begin + 2)
                                    : make(TokenKind::RightContext, begin, begin + 1);
    case ':':
      return make(TokenKind::Colon, begin, begin + 1);
    case '*':
      return make(TokenKind::Star, begin, begin + 1);
    case '(':
      return make(TokenKind::OpenParenthesis, begin, begin + 1);
    case ')':
      return make(TokenKind::CloseParenthesis, begin, begin + 1);
    default:
      break;
  }
  // in free syntax `;` ends a production, except with parameters
  if (c == ';' && isFree_ && at(begin + 1) != '(') {
    return make(TokenKind::EndOfLine, begin, begin + 1);
  }
  if (static_cast<unsigned char>(c) >= 0x80U || static_cast<unsigned char>(c) < 0x20U || c == 0x7F) {
    return invalidCharacter(begin);
  }
  const core::SymbolId declared = symbols_.longestDeclared(rest);
  const std::size_t length = declared == core::kNoSymbol ? 1 : symbols_[declared].name.size();
  Token token = make(TokenKind::Symbol, begin, begin + static_cast<std::uint32_t>(length));
  token.symbol = declared == core::kNoSymbol ? symbols_.internCharacter(c) : declared;
  return token;
}

Token Lexer::scanPlain() {
  const std::uint32_t begin = skipBlanks(position_);
  if (begin >= text_.size()) {
    return make(TokenKind::EndOfFile, begin, begin);
  }
  if (text_[begin] == '\n') {
    return make(TokenKind::EndOfLine, begin, begin + 1);
  }
  if (static_cast<unsigned char>(text_[begin]) >= 0x80U || static_cast<unsigned char>(text_[begin]) < 0x20U) {
    return invalidCharacter(begin);
  }
  const core::SymbolId declared = symbols_.longestDeclared(text_.substr(begin));
  const std::size_t length = declared == core::kNoSymbol ? 1 : symbols_[declared].name.size();
  Token token = make(TokenKind::Symbol, begin, begin + static_cast<std::uint32_t>(length));
  token.symbol = declared == core::kNoSymbol ? symbols_.internCharacter(text_[begin]) : declared;
  return token;
}

Token Lexer::scanExpression() {
  const std::uint32_t begin = skipMeaningless(position_);
  if (begin >= text_.size()) {
    return make(TokenKind::EndOfFile, begin, begin);
  }
  const char c = text_[begin];
  const std::string_view rest = text_.substr(begin);
  if (c == '\n') {
    return make(TokenKind::EndOfLine, begin, begin + 1);
  }
  if (rest.starts_with("-->")) {
    return make(TokenKind::Arrow, begin, begin + 3);
  }
  if (rest.starts_with("-o>")) {
    return make(TokenKind::InstanceArrow, begin, begin + 3);
  }
  if (isDigit(c) || (c == '.' && isDigit(at(begin + 1)))) {
    return number(begin);
  }
  if (isIdentifierStart(c)) {
    std::uint32_t end = begin;
    while (isIdentifierPart(at(end))) {
      ++end;
    }
    // `world.temperature` is one name; a point elsewhere has no meaning
    if (at(end) == '.' && isIdentifierStart(at(end + 1)) && isWorldName(text_.substr(begin, end + 1 - begin))) {
      do {
        ++end;
      } while (isIdentifierPart(at(end)));
    }
    return make(TokenKind::Identifier, begin, end);
  }
  if (c == '"') {
    return string(begin);
  }
  constexpr std::array<std::string_view, 7> kLongOperators{"||", "&&", "==", "!=", "<>", "<=", ">="};
  for (const std::string_view spelling : kLongOperators) {
    if (rest.starts_with(spelling)) {
      return make(TokenKind::Operator, begin, begin + 2);
    }
  }
  if (std::string_view("<>+-/%^!").find(c) != std::string_view::npos) {
    return make(TokenKind::Operator, begin, begin + 1);
  }
  constexpr std::array<std::pair<char, TokenKind>, 13> kSingle{{{'*', TokenKind::Star},
                                                                {':', TokenKind::Colon},
                                                                {'(', TokenKind::OpenParenthesis},
                                                                {')', TokenKind::CloseParenthesis},
                                                                {'=', TokenKind::Assign},
                                                                {'&', TokenKind::Ampersand},
                                                                {'?', TokenKind::Question},
                                                                {',', TokenKind::Comma},
                                                                {';', TokenKind::Semicolon},
                                                                {'{', TokenKind::OpenBrace},
                                                                {'}', TokenKind::CloseBrace},
                                                                {'[', TokenKind::OpenBracket},
                                                                {']', TokenKind::CloseBracket}}};
  for (const auto& [character, kind] : kSingle) {
    if (c == character) {
      return make(kind, begin, begin + 1);
    }
  }
  return invalidCharacter(begin);
}

Token Lexer::number(std::uint32_t begin) const {
  std::uint32_t end = begin;
  while (isDigit(at(end))) {
    ++end;
  }
  const bool hasPoint = at(end) == '.';
  if (hasPoint) {
    ++end;
    while (isDigit(at(end))) {
      ++end;
    }
  }
  std::uint32_t exponentEnd = end;
  if (lower(at(end)) == 'e') {
    const std::uint32_t digits = end + (at(end + 1) == '+' || at(end + 1) == '-' ? 2U : 1U);
    exponentEnd = digits;
    while (isDigit(at(exponentEnd))) {
      ++exponentEnd;
    }
    exponentEnd = exponentEnd == digits ? end : exponentEnd;
  }
  if (exponentEnd > end && !hasPoint) {
    Token token = make(TokenKind::Invalid, begin, exponentEnd);
    const std::string digits(text_.substr(begin, end - begin));
    const std::string exponent(text_.substr(end, exponentEnd - end));
    token.hint = "an exponent needs a decimal point before it: write " + digits + ".0" + exponent;
    return token;
  }
  Token token = make(TokenKind::Number, begin, exponentEnd);
  token.number = core::parseNumber(token.text).value_or(0.0);
  return token;
}

Token Lexer::string(std::uint32_t begin) const {
  std::string value;
  std::uint32_t end = begin + 1;
  while (end < text_.size() && text_[end] != '"' && text_[end] != '\n') {
    char c = text_[end];
    if (c == '\\' && at(end + 1) != '\n' && end + 1 < text_.size()) {
      ++end;
      c = text_[end];
      c = c == 'n' ? '\n' : c == 't' ? '\t' : c == 'r' ? '\r' : c;
    }
    value.push_back(c);
    ++end;
  }
  if (at(end) != '"') {
    Token token = make(TokenKind::Invalid, begin, end);
    token.hint = "the string has no closing '\"' on its line";
    return token;
  }
  Token token = make(TokenKind::String, begin, end + 1);
  token.text = std::move(value);
  return token;
}

void Lexer::skipLine() {
  peekedMode_ = Mode::None;
  std::uint32_t depth = blockDepth_;
  while (position_ < text_.size()) {
    const char c = text_[position_];
    if (c == '\n') {
      Token keyword;
      const std::uint32_t next = static_cast<std::uint32_t>(std::min<std::size_t>(position_ + 1, text_.size()));
      blockDepth_ = 0;
      bracketDepth_ = 0;
      if ((depth == 0 && newlineEnds(position_)) || (depth > 0 && matchKeyword(next, keyword))) {
        ++position_;
        return;
      }
    } else if (depth > 0 && c == '{') {
      ++depth;
    } else if (depth > 0 && c == '}') {
      --depth;
    } else if (depth == 0 && c == ';' && isFree_ && at(position_ + 1) != '(') {
      ++position_;
      break;
    }
    ++position_;
  }
  blockDepth_ = 0;
  bracketDepth_ = 0;
}

void Lexer::skipIndentedLines() {
  peekedMode_ = Mode::None;
  while (at(position_) == ' ') {
    skipLine();
  }
}

bool Lexer::nextLineIsIndented() const {
  std::uint32_t position = position_;
  while (position < text_.size() && isBlank(text_[position])) {
    ++position;
  }
  if (at(position) != '\n' || at(position + 1) != ' ') {
    return false;
  }
  ++position;
  while (isBlank(at(position))) {
    ++position;
  }
  return position < text_.size() && text_[position] != '\n';
}

bool Lexer::lineIsIndented(std::uint32_t position) const {
  std::uint32_t begin = std::min(position, static_cast<std::uint32_t>(text_.size()));
  while (begin > 0 && text_[begin - 1] != '\n') {
    --begin;
  }
  return begin > 0 && at(begin) == ' ';
}

std::string describe(const Token& token) {
  switch (token.kind) {
    case TokenKind::EndOfFile:
      return "the end of the file";
    case TokenKind::EndOfLine:
      return token.text == ";" ? "';'" : "the end of the line";
    case TokenKind::Keyword:
      return "the keyword '" + token.text + "'";
    case TokenKind::Number:
      return "the number " + token.text;
    case TokenKind::String:
      return "a string";
    case TokenKind::Invalid:
      if (static_cast<unsigned char>(token.text.empty() ? ' ' : token.text[0]) >= 0x80U) {
        return "the character '" + token.text + "', which is not 7-bit ASCII";
      }
      if (!token.text.empty() && static_cast<unsigned char>(token.text[0]) < 0x20U) {
        return "a control character (code " + std::to_string(static_cast<int>(token.text[0])) + ")";
      }
      return "'" + token.text + "'";
    default:
      return "'" + token.text + "'";
  }
}

}  // namespace espalier::language

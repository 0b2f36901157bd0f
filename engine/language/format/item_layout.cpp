#include "engine/language/format/item_layout.h"

#include <algorithm>
#include <utility>

#include "engine/language/preprocess/line_reader.h"
#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

bool isOneOf(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

bool isSeparator(TokenKind kind) {
  switch (kind) {
    case TokenKind::LeftContext:
    case TokenKind::RightContext:
    case TokenKind::NewLeftContext:
    case TokenKind::NewRightContext:
    case TokenKind::Colon:
    case TokenKind::Arrow:
    case TokenKind::InstanceArrow:
      return true;
    default:
      return false;
  }
}

/// Whether two characters with a blank between them would be read differently without it.
bool wouldJoin(char left, char right) {
  if (isIdentifierPart(left) || left == '.') {
    return isIdentifierPart(right) || right == '.';
  }
  constexpr std::string_view kOperators = "+-*/%^!<>=&|";
  return kOperators.find(left) != std::string_view::npos && kOperators.find(right) != std::string_view::npos;
}

}  // namespace

std::size_t CodeOfFile::lineAt(std::uint32_t offset) const {
  const auto after = std::upper_bound(lines.begin(), lines.end(), offset,
                                      [](std::uint32_t value, const Line& line) { return value < line.begin; });
  return static_cast<std::size_t>(after - lines.begin()) - 1;
}

CodeOfFile readCode(std::string_view file, const std::unordered_set<std::uint32_t>& activeLineEnds) {
  CodeOfFile result;
  result.file = file;
  LineReader reader(file);
  LogicalLine logical;
  std::uint32_t begin = 0;
  while (reader.next(logical)) {
    CodeOfFile::Line line;
    line.begin = begin;
    const std::size_t newline = file.find('\n', logical.end);
    line.end = static_cast<std::uint32_t>(newline == std::string_view::npos ? file.size() : newline + 1);
    begin = line.end;
    line.startsInComment = logical.startsInComment;
    const std::string_view raw = file.substr(line.begin, logical.end - line.begin);
    line.hasSplice = raw.find("\\\n") != std::string_view::npos || raw.find("\\\r\n") != std::string_view::npos;
    const bool isDirective = !logical.startsInComment && logical.text.starts_with('#');
    line.isCode = !isDirective && activeLineEnds.contains(logical.end);
    if (line.isCode) {
      result.code += logical.text;
      result.offsets.insert(result.offsets.end(), logical.offsets.begin(), logical.offsets.end());
      result.code += '\n';
      result.offsets.push_back(logical.end);
    }
    result.lines.push_back(line);
  }
  return result;
}

ItemLayout::ItemLayout(const CodeOfFile& code, const std::vector<Symbol>& declared)
    : code_(code), lexer_(code_.code, symbols_) {
  for (const Symbol& symbol : declared) {
    if (symbol.isDeclared) {
      core::SymbolId id = core::kNoSymbol;
      symbols_.declare(symbol, &id);
    }
  }
}

std::vector<LaidOutItem> ItemLayout::run(std::uint32_t& untouched) {
  std::vector<LaidOutItem> items;
  isFinished_ = false;
  while (!isFinished_) {
    const std::uint32_t begin = lexer_.position();
    LaidOutItem item;
    const bool isRead = readItem();
    if (!isRead) {
      lexer_.setNesting(blocks_);
      lexer_.skipLine();
      lexer_.setNesting(0);
      lexer_.setBracketDepth(0);
      isFinished_ = lexer_.position() >= code_.code.size();
    }
    if (tokens_.empty() && isRead) {
      continue;
    }
    if (isRead && layOut(item)) {
      items.push_back(std::move(item));
    } else {
      ++untouched;
    }
    if (lexer_.position() == begin) {
      break;
    }
  }
  return items;
}

// ---- reading

bool ItemLayout::readItem() {
  tokens_.clear();
  phase_ = Phase::Start;
  parentheses_ = subscripts_ = branches_ = blocks_ = 0;
  expectsBlock_ = false;
  lexer_.setNesting(0);
  lexer_.setBracketDepth(0);
  while (true) {
    const bool isExpression = parentheses_ > 0 || blocks_ > 0 || phase_ == Phase::Guard || phase_ == Phase::Expression;
    const Token token = phase_ == Phase::Plain ? lexer_.peekPlain()
                        : isExpression         ? lexer_.peekExpression()
                                               : lexer_.peekSymbol();
    // an item with characters that are skipped keeps its text
    if (token.kind == TokenKind::Invalid || lexer_.skipsBeforeToken()) {
      return false;
    }
    if (token.kind == TokenKind::EndOfFile) {
      isFinished_ = true;
      return parentheses_ == 0 && blocks_ == 0;
    }
    if (token.kind == TokenKind::EndOfLine) {
      lexer_.advance();
      // the `{` of Start: may stand on the next line
      if (expectsBlock_) {
        continue;
      }
      if (token.text == ";") {
        place(token, true);
        phase_ = Phase::Start;
        branches_ = 0;
        continue;
      }
      return parentheses_ == 0;
    }
    if (expectsBlock_ && token.kind != TokenKind::OpenBrace) {
      return false;
    }
    lexer_.advance();
    if (!place(token, !isExpression && !isSeparator(token.kind) && token.kind != TokenKind::Keyword)) {
      return false;
    }
  }
}

void ItemLayout::readKeyword(const Token& token) {
  switch (token.keyword) {
    case Keyword::Lsystem:
    case Keyword::Ignore:
    case Keyword::Consider:
      phase_ = Phase::Plain;
      break;
    case Keyword::Syntax:
      phase_ = Phase::Expression;
      lexer_.setFreeSyntax(lexer_.peekExpression().text == "free");
      break;
    case Keyword::Start:
    case Keyword::StartEach:
    case Keyword::End:
    case Keyword::EndEach:
    case Keyword::Define:
      phase_ = Phase::Expression;
      expectsBlock_ = true;
      break;
    case Keyword::Seed:
    case Keyword::DerivationLength:
    case Keyword::MaximumDepth:
    case Keyword::Module:
      phase_ = Phase::Expression;
      break;
    default:
      phase_ = Phase::Modules;
      break;
  }
}

bool ItemLayout::place(const Token& token, bool isInString) {
  Placed placed;
  placed.token = token;
  placed.begin = code_.offsets[token.range.begin];
  placed.end = code_.offsets[token.range.end - 1] + 1;
  placed.blockDepth = blocks_;
  placed.isInString = isInString;
  const bool isFirst = tokens_.empty() || phase_ == Phase::Start;
  const Placed* before = isFirst ? nullptr : &tokens_.back();
  const bool isAfterOperand = before != nullptr && before->isOperand;

  if (isFirst && token.kind == TokenKind::Keyword) {
    readKeyword(token);
    tokens_.push_back(std::move(placed));
    return true;
  }
  if (phase_ == Phase::Start) {
    phase_ = Phase::Head;
  }
  switch (token.kind) {
    case TokenKind::Colon:
      if (parentheses_ == 0 && blocks_ == 0 && (phase_ == Phase::Head || phase_ == Phase::Successor)) {
        phase_ = phase_ == Phase::Head ? Phase::Guard : Phase::Expression;
      }
      break;
    case TokenKind::Arrow:
    case TokenKind::InstanceArrow:
      if (parentheses_ > 0 || blocks_ > 0 || (phase_ != Phase::Head && phase_ != Phase::Guard)) {
        return false;
      }
      phase_ = Phase::Successor;
      break;
    case TokenKind::OpenParenthesis:
      ++parentheses_;
      break;
    case TokenKind::CloseParenthesis:
      if (parentheses_ == 0) {
        return false;
      }
      --parentheses_;
      placed.isOperand = true;
      placed.isInString = parentheses_ == 0 && blocks_ == 0 && phase_ != Phase::Guard && phase_ != Phase::Expression;
      break;
    case TokenKind::OpenBracket:
      ++subscripts_;
      break;
    case TokenKind::CloseBracket:
      subscripts_ -= std::min(subscripts_, 1U);
      placed.isOperand = true;
      break;
    case TokenKind::OpenBrace:
      placed.joinsLine = expectsBlock_;
      expectsBlock_ = false;
      ++blocks_;
      lexer_.setNesting(blocks_);
      break;
    case TokenKind::CloseBrace:
      if (blocks_ == 0) {
        return false;
      }
      --blocks_;
      placed.blockDepth = blocks_;
      lexer_.setNesting(blocks_);
      break;
    case TokenKind::Symbol:
      if (isInString && token.text == "[") {
        ++branches_;
      } else if (isInString && token.text == "]") {
        branches_ -= std::min(branches_, 1U);
      }
      break;
    case TokenKind::Number:
    case TokenKind::String:
      placed.isOperand = true;
      break;
    case TokenKind::Identifier:
      placed.isOperand = !isOneOf(token.text, {"if", "while", "else", "do"});
      break;
    case TokenKind::Ampersand:
      placed.isPrefix = true;
      break;
    case TokenKind::Question:
      // of a declared query module; behind an operand it is the conditional operator
      placed.isPrefix = !isAfterOperand;
      break;
    case TokenKind::Operator:
      placed.isPrefix = !isAfterOperand && isOneOf(token.text, {"-", "!"});
      break;
    case TokenKind::Star:
      placed.isWildcard = !isAfterOperand || isInString;
      break;
    default:
      break;
  }
  placed.isCompact = parentheses_ + subscripts_ > 0;
  if (lexer_.isFreeSyntax()) {
    lexer_.setBracketDepth(parentheses_ + subscripts_ + branches_);
  }
  tokens_.push_back(std::move(placed));
  return true;
}

// ---- writing

bool ItemLayout::isUntouchable(std::size_t firstLine, std::size_t lastLine) const {
  for (std::size_t i = firstLine; i <= lastLine; ++i) {
    const CodeOfFile::Line& line = code_.lines[i];
    if (!line.isCode || line.hasSplice || line.startsInComment) {
      return true;
    }
  }
  return lastLine + 1 < code_.lines.size() && code_.lines[lastLine + 1].startsInComment;
}

bool ItemLayout::layOut(LaidOutItem& item) const {
  item.firstLine = code_.lineAt(tokens_.front().begin);
  item.lastLine = code_.lineAt(tokens_.back().end - 1);
  if (isUntouchable(item.firstLine, item.lastLine)) {
    return false;
  }
  // a comment before the first token stays before it
  Placed lineBegin;
  lineBegin.begin = lineBegin.end = code_.lines[item.firstLine].begin;
  std::string before;
  if (!appendGap(before, lineBegin, tokens_.front())) {
    return false;
  }
  const std::size_t first = before.find_first_not_of(' ');
  item.text = first == std::string::npos ? std::string() : before.substr(first);
  for (std::size_t i = 0; i < tokens_.size(); ++i) {
    if (i > 0 && !appendGap(item.text, tokens_[i - 1], tokens_[i])) {
      return false;
    }
    item.text += code_.file.substr(tokens_[i].begin, tokens_[i].end - tokens_[i].begin);
  }
  // the rest of the last line is a comment
  std::string_view rest = code_.file.substr(tokens_.back().end, code_.lines[item.lastLine].end - tokens_.back().end);
  const std::size_t begin = rest.find_first_not_of(" \t\r\n");
  if (begin != std::string_view::npos) {
    rest = rest.substr(begin, rest.find_last_not_of(" \t\r\n") + 1 - begin);
    item.text += " " + std::string(rest);
  }
  return !item.text.ends_with('\\');
}

std::string ItemLayout::lineStart(std::uint32_t depth, char original) const {
  if (depth > 0) {
    return std::string(std::size_t{2} * depth, ' ');
  }
  if (!lexer_.isFreeSyntax() || original == '\t') {
    return "\t";
  }
  return original == ' ' ? "  " : "";
}

std::string ItemLayout::blankBetween(const Placed& left, const Placed& right) const {
  const TokenKind l = left.token.kind;
  const TokenKind r = right.token.kind;
  const bool hadBlank = right.begin > left.end;
  const std::string kept = hadBlank ? " " : "";
  // strings of modules
  if (l == TokenKind::Keyword || (isSeparator(l) && l != TokenKind::Colon) ||
      (isSeparator(r) && r != TokenKind::Colon)) {
    return " ";
  }
  if (l == TokenKind::EndOfLine) {
    return " ";
  }
  if (r == TokenKind::EndOfLine) {
    return "";
  }
  if (left.isWildcard || right.isWildcard || l == TokenKind::Colon || r == TokenKind::Colon) {
    return " ";
  }
  if (left.isInString && right.isInString) {
    return r == TokenKind::OpenParenthesis ? "" : kept;
  }
  if (l == TokenKind::OpenParenthesis || l == TokenKind::OpenBracket || r == TokenKind::CloseParenthesis ||
      r == TokenKind::CloseBracket || r == TokenKind::Comma || r == TokenKind::Semicolon ||
      r == TokenKind::OpenBracket) {
    return "";
  }
  if (l == TokenKind::Comma) {
    return left.isCompact ? "" : " ";
  }
  if (l == TokenKind::Semicolon || l == TokenKind::OpenBrace || l == TokenKind::CloseBrace ||
      r == TokenKind::OpenBrace || r == TokenKind::CloseBrace) {
    return " ";
  }
  // operators
  if (left.isPrefix) {
    return "";
  }
  const auto isCompactOperator = [](const Placed& placed) {
    return placed.isCompact &&
           (placed.token.kind == TokenKind::Star ||
            (placed.token.kind == TokenKind::Operator && isOneOf(placed.token.text, {"+", "-", "/", "%", "^"})));
  };
  const auto isBinary = [](const Placed& placed) {
    return !placed.isPrefix && (placed.token.kind == TokenKind::Star || placed.token.kind == TokenKind::Operator ||
                                placed.token.kind == TokenKind::Assign || placed.token.kind == TokenKind::Question);
  };
  if (isCompactOperator(left) || (isBinary(right) && isCompactOperator(right))) {
    return "";
  }
  if (isBinary(left) || isBinary(right)) {
    return " ";
  }
  if (r == TokenKind::OpenParenthesis) {
    return l == TokenKind::Identifier && !left.isOperand ? " " : "";
  }
  return kept;
}

bool ItemLayout::appendGap(std::string& text, const Placed& left, const Placed& right) const {
  const std::string_view gap = code_.file.substr(left.end, right.begin - left.end);
  bool hasComment = false;
  std::size_t newlines = 0;
  char afterNewline = '\0';
  const auto breakLine = [&](std::uint32_t depth) {
    text += newlines > 1 && depth > 0 ? "\n\n" : "\n";
    // behind a line of its block a last brace needs no TAB
    const bool isLastBrace = depth == 0 && right.token.kind == TokenKind::CloseBrace;
    text += isLastBrace ? std::string() : lineStart(depth, afterNewline);
    newlines = 0;
  };
  const std::uint32_t commentDepth = right.blockDepth + (right.token.kind == TokenKind::CloseBrace ? 1U : 0U);
  for (std::size_t i = 0; i < gap.size();) {
    if (gap[i] == '\n') {
      ++newlines;
      afterNewline = i + 1 < gap.size() ? gap[i + 1] : right.token.text.empty() ? '\0' : 'x';
      ++i;
    } else if (gap[i] == '/' && i + 1 < gap.size()) {
      const bool isLong = gap[i + 1] == '*';
      const std::size_t found = isLong ? gap.find("*/", i + 2) : gap.find('\n', i);
      std::size_t end = found == std::string_view::npos ? gap.size() : isLong ? found + 2 : found;
      const std::size_t next = end;
      while (end > i && isBlank(gap[end - 1])) {
        --end;
      }
      if (newlines > 0) {
        breakLine(commentDepth);
      } else {
        text += " ";
      }
      std::string_view comment = gap.substr(i, end - i);
      while (comment.ends_with('\r') || comment.ends_with(' ')) {
        comment.remove_suffix(1);
      }
      text += comment;
      hasComment = true;
      i = next;
    } else {
      ++i;
    }
  }
  if (right.joinsLine) {
    text += " ";
    return !hasComment;
  }
  if (newlines > 0) {
    breakLine(right.blockDepth);
    return true;
  }
  if (hasComment) {
    text += " ";
    return true;
  }
  const std::string blank = blankBetween(left, right);
  const bool mustStayApart = blank.empty() && right.begin > left.end && left.end > left.begin &&
                             wouldJoin(code_.file[left.end - 1], code_.file[right.begin]);
  text += mustStayApart ? " " : blank;
  return true;
}

}  // namespace espalier::language

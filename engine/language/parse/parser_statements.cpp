#include <utility>

#include "engine/language/parse/parser.h"

namespace espalier::language {
namespace {

bool isWord(const Token& token, std::string_view word) {
  return token.kind == TokenKind::Identifier && token.text == word;
}

}  // namespace

bool Parser::parseBlock(Block& block) {
  const std::string reading = reading_;
  if (reading == "the condition") {
    reading_ = "a block";
  }
  block.isPresent = true;
  block.range = lexer_.peekExpression().range;
  const bool isGood = parseStatements(block.statements);
  block.range.end = lexer_.position();
  reading_ = reading;
  return isGood;
}

/// Whether the open blocks are more than the limit: an error.
bool Parser::isTooDeep() {
  if (lexer_.blockDepth() <= limits_.maximumExpressionDepth) {
    return false;
  }
  messages_.error(lexer_.peekExpression().range, "blocks are nested deeper than the limit expressionDepth (" +
                                                     std::to_string(limits_.maximumExpressionDepth) + ")");
  return true;
}

/// From `{` to `}`. False: the block could not be read to its end.
bool Parser::parseStatements(std::vector<Statement>& statements) {
  if (!expectExpressionToken(TokenKind::OpenBrace, "'{'")) {
    return false;
  }
  lexer_.enterBlock();
  if (isTooDeep()) {
    return false;
  }
  if (lexer_.peekExpression().kind == TokenKind::CloseBrace) {
    expected("a statement", lexer_.peekExpression(), "an empty block is not allowed; remove it");
  }
  while (lexer_.peekExpression().kind != TokenKind::CloseBrace) {
    // a keyword here means that a brace is missing
    const Token keyword = lexer_.peekKeyword();
    const bool isKeyword =
        keyword.kind == TokenKind::Keyword && (keyword.text.back() == ':' || keyword.keyword == Keyword::Endlsystem);
    // so does an arrow: the block of a production ends before it
    if (lexer_.peekExpression().kind == TokenKind::Arrow || lexer_.peekExpression().kind == TokenKind::InstanceArrow) {
      const Token arrow = lexer_.peekExpression();
      lexer_.setNesting(0);
      return expected("'}'", arrow, "the block is not closed");
    }
    if (isKeyword || lexer_.peekExpression().kind == TokenKind::EndOfFile) {
      return expected("'}'", isKeyword ? keyword : lexer_.peekExpression(), "the block is not closed");
    }
    if (isWord(lexer_.peekExpression(), "for")) {
      expected("a statement", lexer_.peekExpression(), "there is no 'for': i = 0; while (i < n) { ... i = i + 1; }");
      skipStatement(true);
      continue;
    }
    Statement statement;
    const bool outerMissesBraces = std::exchange(missesBraces_, false);
    if (parseStatement(statement)) {
      statements.push_back(std::move(statement));
    } else {
      skipStatement();
    }
    missesBraces_ = outerMissesBraces;
  }
  lexer_.advance();
  lexer_.leaveBlock();
  return true;
}

/// The block of `if`, `else` or `while`. One statement without braces is a mistake, and is read.
bool Parser::parseBody(std::vector<Statement>& statements, const std::string& example) {
  const Token& token = lexer_.peekExpression();
  const bool isStatement = token.kind == TokenKind::Identifier || token.kind == TokenKind::OpenParenthesis;
  if (!isStatement || isWord(token, "else")) {
    return parseStatements(statements);
  }
  if (!std::exchange(missesBraces_, true)) {
    expected("'{'", token, "braces are needed also around one statement: " + example);
  }
  // counts among the nested blocks
  lexer_.enterBlock();
  const bool isGood = !isTooDeep() && parseStatement(statements.emplace_back());
  lexer_.leaveBlock();
  return isGood;
}

/// To the end of the statement, or to the brace that ends the block.
void Parser::skipStatement(bool passesParentheses) {
  expressionDepth_ = 0;
  std::uint32_t depth = 0;
  std::uint32_t parentheses = 0;
  while (true) {
    const Token token = lexer_.peekExpression();
    const Token keyword = lexer_.peekKeyword();
    const bool isKeyword =
        keyword.kind == TokenKind::Keyword && (keyword.text.back() == ':' || keyword.keyword == Keyword::Endlsystem);
    const bool isArrow = token.kind == TokenKind::Arrow || token.kind == TokenKind::InstanceArrow;
    if (token.kind == TokenKind::EndOfFile || isKeyword || isArrow ||
        (depth == 0 && token.kind == TokenKind::CloseBrace)) {
      return;
    }
    // a peeked keyword may have replaced the token
    (void)lexer_.peekExpression();
    lexer_.advance();
    depth += token.kind == TokenKind::OpenBrace ? 1U : 0U;
    depth -= token.kind == TokenKind::CloseBrace ? 1U : 0U;
    if (passesParentheses) {
      parentheses += token.kind == TokenKind::OpenParenthesis ? 1U : 0U;
      parentheses -= token.kind == TokenKind::CloseParenthesis && parentheses > 0 ? 1U : 0U;
    }
    if (depth == 0 && parentheses == 0 && (token.kind == TokenKind::Semicolon || token.kind == TokenKind::CloseBrace)) {
      return;
    }
  }
}

bool Parser::parseStatement(Statement& statement) {
  const Token token = lexer_.peekExpression();
  statement.range.begin = token.range.begin;
  bool isGood = false;
  if (isWord(token, "if")) {
    isGood = parseIf(statement);
  } else if (isWord(token, "while") || isWord(token, "do")) {
    isGood = parseLoop(statement, token.text == "do");
  } else {
    isGood = parseSimpleStatement(statement);
  }
  statement.range.end = lexer_.position();
  return isGood;
}

bool Parser::parseSimpleStatement(Statement& statement) {
  statement.value = parseExpression();
  if (statement.value == kNoExpression) {
    return false;
  }
  if (lexer_.peekExpression().kind == TokenKind::Assign) {
    const ExpressionKind kind = model_.expressions[statement.value].kind;
    if (kind != ExpressionKind::Name && kind != ExpressionKind::Element) {
      return expected("';'", lexer_.peekExpression(), "only a variable or an array element can stand before '='");
    }
    lexer_.advance();
    statement.kind = Statement::Kind::Assign;
    statement.target = statement.value;
    statement.value = parseExpression();
    if (statement.value == kNoExpression) {
      return false;
    }
  }
  const ExpressionNode& node = model_.expressions[statement.value];
  const bool isTypeName =
      node.kind == ExpressionKind::Name && (node.text == "int" || node.text == "float" || node.text == "double");
  if (isTypeName && lexer_.peekExpression().kind == TokenKind::Identifier) {
    return expected("';'", lexer_.peekExpression(),
                    "variables have no types: write " + lexer_.peekExpression().text + " = 0;");
  }
  return expectSemicolon();
}

/// A missing semicolon is reported behind the statement that lacks it, also when the next one is on another line.
bool Parser::expectSemicolon() {
  const std::uint32_t end = lexer_.position();
  const Token token = lexer_.peekExpression();
  const std::size_t newline = lexer_.text().substr(0, token.range.begin).find('\n', end);
  if (token.kind == TokenKind::Semicolon || newline == std::string_view::npos || token.kind == TokenKind::EndOfFile) {
    return token.kind == TokenKind::CloseBrace ? expected("';'", token, "every statement ends with ';'")
                                               : expectExpressionToken(TokenKind::Semicolon, "';'");
  }
  Token lineEnd;
  lineEnd.kind = TokenKind::EndOfLine;
  lineEnd.range = {end, end + 1};
  messages_.error(lineEnd.range, "expected ';' while reading " + describeReading() + ", found " + describe(lineEnd),
                  "every statement ends with ';'");
  return false;
}

bool Parser::parseStatementCondition(ExpressionIndex& condition, std::string_view name) {
  const Token& open = lexer_.peekExpression();
  if (open.kind != TokenKind::OpenParenthesis) {
    return expected("'(' after '" + std::string(name) + "'", open,
                    "put the condition in parentheses: " + std::string(name) + " (n > 1) { ... }");
  }
  lexer_.advance();
  condition = parseExpression();
  return condition != kNoExpression && expectExpressionToken(TokenKind::CloseParenthesis, "')'");
}

bool Parser::parseIf(Statement& statement) {
  statement.kind = Statement::Kind::If;
  lexer_.advance();
  if (!parseStatementCondition(statement.value, "if") || !parseBody(statement.body, "if (...) { ... } else { ... }")) {
    return false;
  }
  if (!isWord(lexer_.peekExpression(), "else")) {
    return true;
  }
  lexer_.advance();
  return parseBody(statement.otherwise,
                   isWord(lexer_.peekExpression(), "if") ? "else { if (...) { ... } }" : "else { ... }");
}

bool Parser::parseLoop(Statement& statement, bool isDo) {
  lexer_.advance();
  if (!isDo) {
    statement.kind = Statement::Kind::While;
    return parseStatementCondition(statement.value, "while") && parseBody(statement.body, "while (...) { ... }");
  }
  statement.kind = Statement::Kind::DoWhile;
  if (!parseBody(statement.body, "do { ... } while (...);")) {
    return false;
  }
  if (!isWord(lexer_.peekExpression(), "while")) {
    return expected("'while'", lexer_.peekExpression(), "a loop that starts with 'do' ends with 'while (condition);'");
  }
  lexer_.advance();
  return parseStatementCondition(statement.value, "while") && expectExpressionToken(TokenKind::Semicolon, "';'");
}

}  // namespace espalier::language

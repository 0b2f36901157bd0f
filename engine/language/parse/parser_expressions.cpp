#include <algorithm>
#include <array>
#include <utility>

#include "engine/core/work_meter.h"
#include "engine/language/parse/parser.h"

namespace espalier::language {
namespace {

struct BinaryOperator {
  std::string_view text;
  int precedence;
  Operation operation;
};

// all are left-associative, the power too
constexpr std::array<BinaryOperator, 15> kBinaryOperators{{{"||", 1, Operation::LogicalOr},
                                                           {"&&", 2, Operation::LogicalAnd},
                                                           {"==", 3, Operation::Equal},
                                                           {"!=", 3, Operation::NotEqual},
                                                           {"<>", 3, Operation::NotEqual},
                                                           {"<", 4, Operation::Less},
                                                           {"<=", 4, Operation::LessEqual},
                                                           {">", 4, Operation::Greater},
                                                           {">=", 4, Operation::GreaterEqual},
                                                           {"+", 5, Operation::Add},
                                                           {"-", 5, Operation::Subtract},
                                                           {"*", 6, Operation::Multiply},
                                                           {"/", 6, Operation::Divide},
                                                           {"%", 6, Operation::Modulo},
                                                           {"^", 7, Operation::Power}}};

// a long sum is not nested, but some checks call themselves for each of its operators
constexpr std::uint32_t kOperatorsPerLevel = 50;

const BinaryOperator* findOperator(const Token& token) {
  if (token.kind != TokenKind::Operator && token.kind != TokenKind::Star) {
    return nullptr;
  }
  const auto found = std::find_if(kBinaryOperators.begin(), kBinaryOperators.end(),
                                  [&](const BinaryOperator& candidate) { return candidate.text == token.text; });
  return found == kBinaryOperators.end() ? nullptr : &*found;
}

bool isReserved(std::string_view name) {
  return name == "if" || name == "else" || name == "while" || name == "do";
}

}  // namespace

ExpressionIndex Parser::makeNode(ExpressionNode node) {
  core::pollWork();
  for (const ExpressionIndex child : node.children) {
    const ExpressionNode& operand = model_.expressions[child];
    const bool isLeft = node.kind == ExpressionKind::Binary && child == node.children.front();
    node.depth = std::max(node.depth, operand.depth + 1);
    node.nesting = std::max(node.nesting, operand.nesting + (isLeft ? 0 : 1));
  }
  if (node.nesting > limits_.maximumExpressionDepth) {
    messages_.error(node.range,
                    "the expression is nested deeper than the limit expressionDepth (" +
                        std::to_string(limits_.maximumExpressionDepth) + ")",
                    "assign parts of it to variables first");
    return kNoExpression;
  }
  const std::uint64_t mostOperators = std::uint64_t{kOperatorsPerLevel} * limits_.maximumExpressionDepth;
  if (node.depth > mostOperators + 1) {
    messages_.error(node.range,
                    "the expression has more than " + std::to_string(mostOperators) + " operators in a row, " +
                        std::to_string(kOperatorsPerLevel) + " for each level of the limit expressionDepth (" +
                        std::to_string(limits_.maximumExpressionDepth) + ")",
                    "assign parts of it to variables first");
    return kNoExpression;
  }
  model_.expressions.push_back(std::move(node));
  return static_cast<ExpressionIndex>(model_.expressions.size() - 1);
}

ExpressionIndex Parser::parseExpression() {
  const ExpressionIndex condition = parseBinary(1);
  if (condition == kNoExpression || lexer_.peekExpression().kind != TokenKind::Question) {
    return condition;
  }
  if (expressionDepth_ >= limits_.maximumExpressionDepth) {
    return parseParentheses();
  }
  ++expressionDepth_;
  lexer_.advance();
  const ExpressionIndex first = parseExpression();
  if (first == kNoExpression || !expectExpressionToken(TokenKind::Colon, "':'")) {
    return kNoExpression;
  }
  const ExpressionIndex second = parseExpression();
  --expressionDepth_;
  if (second == kNoExpression) {
    return kNoExpression;
  }
  ExpressionNode node;
  node.kind = ExpressionKind::Conditional;
  node.children = {condition, first, second};
  node.range = {rangeOf(condition).begin, rangeOf(second).end};
  return makeNode(std::move(node));
}

ExpressionIndex Parser::parseBinary(int least) {
  ExpressionIndex left = parseUnary();
  while (left != kNoExpression) {
    const BinaryOperator* operation = findOperator(lexer_.peekExpression());
    if (operation == nullptr || operation->precedence < least) {
      break;
    }
    lexer_.advance();
    const ExpressionIndex right = parseBinary(operation->precedence + 1);
    if (right == kNoExpression) {
      return kNoExpression;
    }
    ExpressionNode node;
    node.kind = ExpressionKind::Binary;
    node.operation = operation->operation;
    node.children = {left, right};
    node.range = {rangeOf(left).begin, rangeOf(right).end};
    left = makeNode(std::move(node));
  }
  return left;
}

ExpressionIndex Parser::parseUnary() {
  const Token token = lexer_.peekExpression();
  if (token.kind != TokenKind::Operator || (token.text != "-" && token.text != "!")) {
    return parsePrimary();
  }
  if (expressionDepth_ >= limits_.maximumExpressionDepth) {
    return parseParentheses();
  }
  ++expressionDepth_;
  lexer_.advance();
  const ExpressionIndex operand = parseUnary();
  --expressionDepth_;
  if (operand == kNoExpression) {
    return kNoExpression;
  }
  ExpressionNode node;
  node.kind = ExpressionKind::Unary;
  node.operation = token.text == "-" ? Operation::Negate : Operation::Not;
  node.children = {operand};
  node.range = {token.range.begin, rangeOf(operand).end};
  return makeNode(std::move(node));
}

ExpressionIndex Parser::parsePrimary() {
  const Token token = lexer_.peekExpression();
  switch (token.kind) {
    case TokenKind::Number:
    case TokenKind::String: {
      lexer_.advance();
      ExpressionNode node;
      node.kind = token.kind == TokenKind::Number ? ExpressionKind::Number : ExpressionKind::String;
      node.number = token.number;
      node.text = token.text;
      node.range = token.range;
      return makeNode(std::move(node));
    }
    case TokenKind::Identifier:
      if (!isReserved(token.text)) {
        return parseName();
      }
      break;
    case TokenKind::OpenParenthesis:
      return parseParentheses();
    case TokenKind::Ampersand: {
      lexer_.advance();
      if (lexer_.peekExpression().kind != TokenKind::Identifier) {
        expected("a variable after '&'", lexer_.peekExpression());
        return kNoExpression;
      }
      const ExpressionIndex variable = parseName();
      if (variable == kNoExpression) {
        return kNoExpression;
      }
      ExpressionNode node;
      node.kind = ExpressionKind::Reference;
      node.children = {variable};
      node.range = {token.range.begin, rangeOf(variable).end};
      return makeNode(std::move(node));
    }
    default:
      break;
  }
  expected("an expression", token);
  return kNoExpression;
}

ExpressionIndex Parser::parseParentheses() {
  const Token open = lexer_.peekExpression();
  if (expressionDepth_ >= limits_.maximumExpressionDepth) {
    messages_.error(open.range,
                    "the expression is nested deeper than the limit expressionDepth (" +
                        std::to_string(limits_.maximumExpressionDepth) + ")",
                    "assign parts of it to variables first");
    return kNoExpression;
  }
  ++expressionDepth_;
  lexer_.advance();
  const std::uint32_t depth = lexer_.bracketDepth();
  lexer_.setBracketDepth(depth + 1);
  const ExpressionIndex inner = parseExpression();
  --expressionDepth_;
  if (inner == kNoExpression) {
    return kNoExpression;
  }
  const Token close = lexer_.peekExpression();
  if (close.kind != TokenKind::CloseParenthesis) {
    expected("')'", close, unclosedHint(open.range, close));
    return kNoExpression;
  }
  lexer_.advance();
  lexer_.setBracketDepth(depth);
  // the parentheses belong to the range that messages show
  model_.expressions[inner].range = {open.range.begin, close.range.end};
  return inner;
}

/// A variable, an array element or a call.
ExpressionIndex Parser::parseName() {
  const Token name = lexer_.peekExpression();
  if (expressionDepth_ >= limits_.maximumExpressionDepth) {
    return parseParentheses();
  }
  lexer_.advance();
  ExpressionNode node;
  node.kind = ExpressionKind::Name;
  node.text = name.text;
  node.nameRange = name.range;
  ++expressionDepth_;
  bool isGood = true;
  if (lexer_.peekExpression().kind == TokenKind::OpenParenthesis) {
    node.kind = ExpressionKind::Call;
    const core::SourceRange open = lexer_.peekExpression().range;
    lexer_.advance();
    const std::uint32_t depth = lexer_.bracketDepth();
    lexer_.setBracketDepth(depth + 1);
    if (lexer_.peekExpression().kind == TokenKind::CloseParenthesis) {
      isGood = expected("an argument of '" + name.text + "'", lexer_.peekExpression(),
                        "every function needs an argument, sometimes only a dummy: " + name.text + "(0)");
    } else {
      isGood = parseArguments(node.children, open);
    }
    if (isGood) {
      lexer_.setBracketDepth(depth);
    }
  }
  while (isGood && node.kind != ExpressionKind::Call && lexer_.peekExpression().kind == TokenKind::OpenBracket) {
    node.kind = ExpressionKind::Element;
    lexer_.advance();
    const ExpressionIndex subscript = parseExpression();
    const Token close = subscript == kNoExpression ? Token{} : lexer_.peekExpression();
    if (subscript == kNoExpression) {
      isGood = false;
    } else if (close.kind != TokenKind::CloseBracket) {
      isGood = expected(
          "']'", close,
          close.kind == TokenKind::Comma ? "every dimension has its own brackets: " + name.text + "[i][j]" : "");
    } else {
      lexer_.advance();
      node.children.push_back(subscript);
    }
  }
  --expressionDepth_;
  node.range = {name.range.begin, lexer_.position()};
  return isGood ? makeNode(std::move(node)) : kNoExpression;
}

/// Expressions separated by commas, and the closing parenthesis.
bool Parser::parseArguments(std::vector<ExpressionIndex>& arguments, core::SourceRange open) {
  while (true) {
    const ExpressionIndex argument = parseExpression();
    if (argument == kNoExpression) {
      return false;
    }
    arguments.push_back(argument);
    const Token& token = lexer_.peekExpression();
    if (token.kind == TokenKind::CloseParenthesis) {
      lexer_.advance();
      return true;
    }
    if (token.kind != TokenKind::Comma) {
      return expected("',' or ')'", token, unclosedHint(open, token));
    }
    lexer_.advance();
  }
}

}  // namespace espalier::language

#include <algorithm>
#include <utility>

#include "engine/core/work_meter.h"
#include "engine/language/parse/foreign_lines.h"
#include "engine/language/parse/parser.h"

namespace espalier::language {
namespace {

// the place of a separator among newLeft << left < predecessor > right >> newRight
int rankOf(TokenKind separator) {
  switch (separator) {
    case TokenKind::NewLeftContext:
      return 0;
    case TokenKind::LeftContext:
      return 1;
    case TokenKind::RightContext:
      return 2;
    default:
      return 3;
  }
}

}  // namespace

/// A part of a production's head between two of `<< < > >>`.
struct Parser::Segment {
  std::vector<FormalModuleSyntax> modules;
  bool isStar = false;
  core::SourceRange range;  // empty: the part is absent
  core::SourceRange starRange;
};

void Parser::parseProduction(ProductionListSyntax& list) {
  ProductionSyntax production;
  const std::uint32_t begin = lexer_.peekSymbol().range.begin;
  productionBegin_ = begin;
  lexer_.setBracketDepth(0);
  reading_ = "a production";
  predecessor_ = {};
  if (!parseHead(production) || !parseGuard(production) || !parseSuccessor(production)) {
    recover();
    return;
  }
  production.range.begin = begin;
  list.productions.push_back(std::move(production));
}

std::string Parser::productionHint(std::uint32_t begin) const {
  const std::string_view line = lineAt(begin);
  if (startsInComment(begin)) {
    return continuationHint(begin);
  }
  if (line.starts_with('[') || line.starts_with(']')) {
    return "a line that begins in column 1 is a new production; to continue the successor above, begin the line with a "
           "TAB";
  }
  const std::size_t colon = line.find(':');
  if (colon != std::string_view::npos) {
    static const std::vector<std::string_view> kKeywords{
        "decomposition", "homomorphism", "maximum depth", "derivation length", "seed", "consider", "ignore", "define"};
    const std::string_view near = core::nearestName(line.substr(0, colon), kKeywords);
    if (!near.empty()) {
      return "did you mean '" + std::string(near) + ":'?";
    }
  }
  std::string continued = continuationHint(begin);
  return continued.empty() && line.find("-->") == std::string_view::npos ? "a production is written as A --> AB"
                                                                         : continued;
}

/// Reports a line that cannot be a production: it starts with blanks instead of a TAB, or with a misspelt section word.
/// True: the line was reported and skipped.
bool Parser::skipsNoProduction(std::string_view name) {
  const Token token = lexer_.peekSymbol();
  const std::string_view line = lineAt(token.range.begin);
  // the arrow may stand on a line that continues this one
  std::string_view whole = lexer_.text().substr(token.range.begin);
  std::size_t lineEnd = whole.find('\n');
  const auto continues = [&](char c) { return c == '\t' || (c == ' ' && lexer_.isFreeSyntax()); };
  while (lineEnd + 1 < whole.size() && lineEnd != std::string_view::npos && continues(whole[lineEnd + 1])) {
    lineEnd = whole.find('\n', lineEnd + 1);
  }
  whole = whole.substr(0, lineEnd);
  if (whole.find('>') != std::string_view::npos || whole.find('{') != std::string_view::npos) {
    return false;
  }
  if (std::string continued = continuationHint(token.range.begin); !continued.empty()) {
    expected("a production", token, std::move(continued));
    recover();
    lexer_.skipIndentedLines();
    return true;
  }
  reading_ = name;
  if (!skipForeignLine("a production", token).advice.empty()) {
    return true;
  }
  static const std::vector<std::string_view> kWords{"decomposition", "homomorphism", "endlsystem", "maximum depth"};
  const std::size_t end = std::min(line.find(':'), line.find_last_not_of(" \t\r") + 1);
  const std::string_view word = line.substr(0, end);
  const bool isEnd = word == "end" || word == "End" || word == "END" || word.starts_with("end ");
  const std::string_view near = isEnd             ? "endlsystem"
                                : word.size() < 4 ? std::string_view()
                                                  : core::nearestName(word, kWords);
  if (near.empty()) {
    return false;
  }
  Token misspelt = token;
  misspelt.text = word;
  misspelt.range.end = token.range.begin + static_cast<std::uint32_t>(word.size());
  expected(near == "endlsystem" ? "a production or 'endlsystem'" : "a production", misspelt,
           "did you mean '" + std::string(near) + "'?");
  // a misspelt endlsystem: the end of the file is not another mistake
  hasReportedEnd_ = hasReportedEnd_ || near == "endlsystem";
  recover();
  return true;
}

/// Reports a mistake in the production that begins at `begin`; at its arrow when that is misspelt.
bool Parser::expectedArrow(std::string_view what, const Token& token, std::uint32_t begin, std::string hint) {
  const std::string_view line = lineAt(begin);
  std::size_t arrow = std::min(line.find("->"), line.find("=>"));
  arrow = std::min(arrow, line.find("--"));
  const bool hasArrow = line.find("-->") != std::string_view::npos || line.find("-o>") != std::string_view::npos;
  // a wrong character may be the first stroke
  const bool isEarlier = token.kind == TokenKind::Invalid && token.range.begin <= begin + arrow;
  if (!hasArrow && arrow != std::string_view::npos && !isEarlier) {
    Token misspelt;
    misspelt.kind = TokenKind::Operator;
    // `==>` too
    const std::size_t first = arrow > 0 && line[arrow] == '=' && line[arrow - 1] == '=' ? arrow - 1 : arrow;
    misspelt.text = std::string(line.substr(first, arrow + 2 - first));
    misspelt.range = {begin + static_cast<std::uint32_t>(first), begin + static_cast<std::uint32_t>(arrow) + 2};
    const bool isMarkup = line.substr(first).starts_with("--&gt;");
    return expected(
        "'-->'", misspelt,
        isMarkup ? "'&gt;' is how web pages write '>': write '-->'" : "the arrow of a production has two strokes");
  }
  // `A \rightarrow AB`
  for (std::size_t at = line.find('\\'); at != std::string_view::npos; at = line.find('\\', at + 1)) {
    const std::string_view command = latexCommand(line.substr(at));
    if (token.kind == TokenKind::EndOfLine && command.ends_with("arrow")) {
      Token arrowWord;
      arrowWord.kind = TokenKind::Operator;
      arrowWord.text = std::string(command);
      arrowWord.range = {begin + static_cast<std::uint32_t>(at),
                         begin + static_cast<std::uint32_t>(at + command.size())};
      return expected("'-->'", arrowWord, latexAdvice(command));
    }
  }
  // `A = AB`
  const std::size_t equals = line.find('=');
  if (token.kind == TokenKind::EndOfLine && equals != std::string_view::npos && equals > 0 &&
      line.find('>') == std::string_view::npos) {
    Token sign;
    sign.kind = TokenKind::Operator;
    sign.text = "=";
    sign.range = {begin + static_cast<std::uint32_t>(equals), begin + static_cast<std::uint32_t>(equals) + 1};
    return expected("'-->'", sign, "the arrow of a production is '-->'");
  }
  return expected(what, token, hint.empty() ? productionHint(begin) : std::move(hint));
}

// ---- head: contexts and predecessor

bool Parser::parseHead(ProductionSyntax& production) {
  const std::uint32_t begin = lexer_.peekSymbol().range.begin;
  std::vector<Segment> segments;
  std::vector<Token> separators;
  if (!parseSegments(segments, separators) || !assignSegments(segments, separators, production)) {
    return false;
  }
  const Token token = lexer_.peekSymbol();
  if (token.kind != TokenKind::Colon && token.kind != TokenKind::Arrow && token.kind != TokenKind::InstanceArrow) {
    return expectedArrow("'-->'", token, begin);
  }
  predecessor_ = production.predecessorRange;
  if (token.kind == TokenKind::Arrow && separators.empty() && production.predecessor.size() > 1 &&
      lexer_.text().substr(production.predecessorRange.end - 1).starts_with("--->")) {
    messages_.warning({token.range.begin - 1, token.range.end},
                      "'--->' is read as the module '-' of the predecessor and the arrow '-->'",
                      "the arrow of a production has two strokes; put a blank behind a module '-'");
  }
  return true;
}

bool Parser::parseSegments(std::vector<Segment>& segments, std::vector<Token>& separators) {
  segments.emplace_back();
  while (true) {
    core::pollWork();
    const Token token = lexer_.peekSymbol();
    Segment& segment = segments.back();
    switch (token.kind) {
      case TokenKind::Symbol: {
        FormalModuleSyntax& module = segment.modules.emplace_back();
        if (!parseFormalModule(module)) {
          return false;
        }
        segment.range = {segment.range.end == 0 ? token.range.begin : segment.range.begin, module.range.end};
        break;
      }
      case TokenKind::Star:
        segment.isStar = true;
        segment.starRange = token.range;
        segment.range = {segment.range.end == 0 ? token.range.begin : segment.range.begin, token.range.end};
        lexer_.advance();
        break;
      case TokenKind::LeftContext:
      case TokenKind::RightContext:
      case TokenKind::NewLeftContext:
      case TokenKind::NewRightContext:
        separators.push_back(token);
        segments.emplace_back();
        lexer_.advance();
        break;
      default:
        return true;
    }
  }
}

bool Parser::assignSegments(std::vector<Segment>& segments, const std::vector<Token>& separators,
                            ProductionSyntax& production) {
  // separators come in the order << < > >>, each at most once
  std::size_t strict = 0;
  for (std::size_t i = 0; i < separators.size(); ++i) {
    if (i > 0 && rankOf(separators[i].kind) <= rankOf(separators[i - 1].kind)) {
      return expected("'-->'", separators[i], "the order is: newLeft << left < predecessor > right >> newRight");
    }
    strict += rankOf(separators[i].kind) < 2 ? 1U : 0U;
  }
  Segment& predecessor = segments[strict];
  if (predecessor.isStar) {
    Token star;
    star.kind = TokenKind::Star;
    star.text = "*";
    star.range = predecessor.starRange;
    return expected("a predecessor", star,
                    "there is no wildcard predecessor; '*' stands for a whole context, condition or successor");
  }
  if (predecessor.modules.empty()) {
    const bool isLast = strict == separators.size();
    return expected("a predecessor", isLast ? lexer_.peekSymbol() : separators[strict]);
  }
  production.predecessor = std::move(predecessor.modules);
  production.predecessorRange = predecessor.range;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (i == strict) {
      continue;
    }
    const Token& separator = separators[i < strict ? i : i - 1];
    const bool isRight = i > strict;
    if (segments[i].range.end == 0) {
      const Token& after = i < separators.size() ? separators[i] : lexer_.peekSymbol();
      return expected("a context " + std::string(isRight ? "after '" : "before '") + separator.text + "'", after);
    }
    if (!checkContext(segments[i], isRight)) {
      return false;
    }
    std::vector<ContextElementSyntax>& context = rankOf(separator.kind) == 0   ? production.newLeftContext
                                                 : rankOf(separator.kind) == 1 ? production.leftContext
                                                 : rankOf(separator.kind) == 2 ? production.rightContext
                                                                               : production.newRightContext;
    for (FormalModuleSyntax& module : segments[i].modules) {
      ContextElementSyntax element;
      const ModuleType type = model_.symbols.types()[module.type];
      const char character = type.arity == 0 ? model_.symbols[type.symbol].character() : '\0';
      if (isRight) {
        element.kind = character == '['   ? ContextElement::Kind::OpenBranch
                       : character == ']' ? ContextElement::Kind::CloseBranch
                       : character == '=' ? ContextElement::Kind::SkipToBranchEnd
                                          : ContextElement::Kind::Module;
      } else if (character == '[' || character == ']') {
        messages_.warning(module.range, "a bracket in a left context never matches",
                          "the left context steps over brackets by itself");
      }
      element.module = std::move(module);
      context.push_back(std::move(element));
    }
    if (isRight && !context.empty() && context.back().kind == ContextElement::Kind::SkipToBranchEnd) {
      messages_.error(context.back().module.range, "'=' must be followed by another module in a right context",
                      "'=' goes to the end of the branch: write '=]'");
      return false;
    }
  }
  return true;
}

bool Parser::checkContext(const Segment& segment, bool isRight) {
  if (segment.isStar && !segment.modules.empty()) {
    messages_.error(
        segment.starRange,
        "'*' stands for a whole " + std::string(isRight ? "right" : "left") + " context, not for one module",
        "there is no wildcard for a single module");
    return false;
  }
  return true;
}

// ---- condition and successor

bool Parser::parseGuard(ProductionSyntax& production) {
  if (lexer_.peekSymbol().kind == TokenKind::Colon) {
    lexer_.advance();
    reading_ = "the condition";
    if (lexer_.peekExpression().kind == TokenKind::OpenBrace && !parseBlock(production.preBlock)) {
      return false;
    }
    reading_ = "the condition";
    if (lexer_.peekExpression().kind == TokenKind::Star) {
      lexer_.advance();
    } else if (lexer_.peekExpression().kind == TokenKind::Arrow ||
               lexer_.peekExpression().kind == TokenKind::InstanceArrow) {
      return expected("a condition", lexer_.peekExpression(), "write '*' for the condition that is always true");
    } else {
      production.condition = parseExpression();
      if (production.condition == kNoExpression) {
        return false;
      }
    }
    if (lexer_.peekExpression().kind == TokenKind::OpenBrace && !parseBlock(production.postBlock)) {
      return false;
    }
    reading_ = "the condition";
  }
  const Token& token = lexer_.peekExpression();
  if (token.kind != TokenKind::Arrow && token.kind != TokenKind::InstanceArrow) {
    return expectedArrow("'-->'", token, productionBegin_);
  }
  lexer_.advance();
  return true;
}

bool Parser::parseSuccessor(ProductionSyntax& production) {
  reading_ = "the successor";
  lexer_.setBracketDepth(0);
  if (lexer_.peekSymbol().kind == TokenKind::Star) {
    production.range.end = lexer_.peekSymbol().range.end;
    lexer_.advance();
  } else {
    if (!parseModules(production.successor)) {
      return false;
    }
    if (production.successor.empty()) {
      return expected("a module or '*'", lexer_.peekSymbol(), "'*' is the empty successor");
    }
    production.range.end = production.successor.back().range.end;
  }
  if (lexer_.peekSymbol().kind == TokenKind::Colon) {
    lexer_.advance();
    reading_ = "the probability";
    production.probability = parseExpression();
    return production.probability != kNoExpression && expectLineEnd(lexer_.peekExpression());
  }
  const Token& token = lexer_.peekSymbol();
  if (token.kind == TokenKind::EndOfLine || token.kind == TokenKind::EndOfFile) {
    return expectLineEnd(token);
  }
  return expected(production.successor.empty() ? "the end of the line" : "a module, ':' or the end of the line", token,
                  token.kind == TokenKind::Star               ? "'*' alone is the empty successor"
                  : token.kind == TokenKind::CloseParenthesis ? "no '(' is open here"
                                                              : "");
}

// ---- modules

bool Parser::internModule(core::SymbolId symbol, std::size_t arity, core::SourceRange range, core::ModuleTypeId& type) {
  const Symbol& declared = model_.symbols[symbol];
  const bool hasAny = declared.parameterNames.size() == 1 && declared.parameterNames.front() == kAnyParameters;
  if (declared.isDeclared && !hasAny && declared.parameterNames.size() != arity) {
    std::string form = declared.name;
    for (std::size_t i = 0; i < declared.parameterNames.size(); ++i) {
      form += (i == 0 ? "(" : ", ") + declared.parameterNames[i];
    }
    form += declared.parameterNames.empty() ? "" : ")";
    messages_.error(range,
                    "expected " + std::to_string(declared.parameterNames.size()) +
                        (declared.parameterNames.size() == 1 ? " parameter" : " parameters") + " of the module '" +
                        declared.name + "' while reading " + describeReading() + ", found " + std::to_string(arity),
                    "it is declared as " + form);
  }
  if (arity > limits_.maximumArity || arity > 0xFFFFU) {
    messages_.error(range, "the module '" + declared.name + "' has " + std::to_string(arity) +
                               " parameters, more than the limit arity (" + std::to_string(limits_.maximumArity) + ")");
    return false;
  }
  type = model_.symbols.internType(symbol, static_cast<std::uint16_t>(arity));
  if (type == core::kNoModuleType) {
    messages_.error(range, "the model has more than 65535 kinds of modules");
  }
  return type != core::kNoModuleType;
}

bool Parser::parseFormalModule(FormalModuleSyntax& module) {
  const Token name = lexer_.peekSymbol();
  lexer_.advance();
  module.range = name.range;
  if (lexer_.peekSymbol().kind == TokenKind::OpenParenthesis) {
    const std::uint32_t depth = lexer_.bracketDepth();
    do {
      lexer_.advance();
      lexer_.setBracketDepth(depth + 1);
      const Token parameter = lexer_.peekExpression();
      if (parameter.kind != TokenKind::Identifier) {
        std::string hint;
        if (parameter.kind == TokenKind::CloseParenthesis) {
          hint = module.parameters.empty() ? "a module without parameters has no parentheses"
                                           : "there is a comma too many";
        } else if (parameter.kind == TokenKind::Number) {
          hint =
              "parameters of predecessors and contexts are names; compare values in the condition, as in A(x) : x == "
              "1";
        }
        return expectedArrow("a parameter name", parameter, productionBegin_, std::move(hint));
      }
      module.parameters.push_back({parameter.text, parameter.range});
      lexer_.advance();
    } while (lexer_.peekExpression().kind == TokenKind::Comma);
    const Token close = lexer_.peekExpression();
    if (close.kind != TokenKind::CloseParenthesis) {
      return expectedArrow("',' or ')'", close, productionBegin_,
                           "parameters of predecessors and contexts are names, separated by commas: A(x, y)");
    }
    module.range.end = close.range.end;
    lexer_.advance();
    lexer_.setBracketDepth(depth);
  }
  return internModule(name.symbol, module.parameters.size(), module.range, module.type);
}

bool Parser::parseModules(std::vector<ModuleSyntax>& modules) {
  while (lexer_.peekSymbol().kind == TokenKind::Symbol) {
    if (!parseModule(modules)) {
      return false;
    }
  }
  return true;
}

bool Parser::parseModule(std::vector<ModuleSyntax>& modules) {
  core::pollWork();
  const Token name = lexer_.peekSymbol();
  ModuleSyntax& module = modules.emplace_back();
  module.range = name.range;
  lexer_.advance();
  if (name.text == "\\") {
    warnAboutLatex(name.range.begin);
  }
  // free syntax: a newline inside brackets does not end the production
  std::uint32_t depth = lexer_.bracketDepth();
  if (lexer_.isFreeSyntax() && (name.text == "[" || name.text == "]")) {
    depth = name.text == "[" ? depth + 1 : depth - std::min(depth, 1U);
    lexer_.setBracketDepth(depth);
  }
  if (lexer_.peekSymbol().kind == TokenKind::OpenParenthesis) {
    const core::SourceRange open = lexer_.peekSymbol().range;
    lexer_.advance();
    lexer_.setBracketDepth(depth + 1);
    if (lexer_.peekExpression().kind == TokenKind::CloseParenthesis) {
      return expected("an expression", lexer_.peekExpression(), "a module without parameters has no parentheses");
    }
    if (!parseArguments(module.parameters, open)) {
      return false;
    }
    module.range.end = lexer_.position();
    lexer_.setBracketDepth(depth);
  }
  return internModule(name.symbol, module.parameters.size(), module.range, module.type);
}

}  // namespace espalier::language

#include <utility>

#include "engine/language/parse/parser.h"

namespace espalier::language {

// ---- items before the axiom

void Parser::parseItem(LSystemSyntax& system) {
  const Token token = lexer_.peekSymbol();
  if (token.keyword == Keyword::Syntax) {
    return parseSyntaxItem();
  }
  if (token.keyword == Keyword::Module) {
    return parseModuleItem();
  }
  lexer_.advance();
  switch (token.keyword) {
    case Keyword::Ring:
      system.isRing = true;
      reading_ = "'Ring Lsystem'";
      if (!expectLineEnd(lexer_.peekSymbol())) {
        recover();
      }
      break;
    case Keyword::Seed:
      parseValueItem(system.seed, "'seed:'");
      break;
    case Keyword::DerivationLength:
      system.derivationLengthRange = token.range;
      parseValueItem(system.derivationLength, "'derivation length:'");
      break;
    case Keyword::Ignore:
      parseSymbolList(system.ignored, "'ignore:'");
      break;
    case Keyword::Consider:
      system.hasConsider = true;
      parseSymbolList(system.considered, "'consider:'");
      break;
    case Keyword::Define:
      parseDefine(system);
      break;
    case Keyword::Start:
      parseItemBlock(system.start, "Start");
      break;
    case Keyword::StartEach:
      parseItemBlock(system.startEach, "StartEach");
      break;
    case Keyword::EndEach:
      parseItemBlock(system.endEach, "EndEach");
      break;
    case Keyword::End:
      parseItemBlock(system.end, "End");
      break;
    default:
      expected("an item or 'Axiom:'", token, "this keyword belongs to a decomposition or homomorphism");
      recover();
      break;
  }
}

void Parser::parseValueItem(ExpressionIndex& value, std::string_view name) {
  reading_ = name;
  value = parseExpression();
  if (value == kNoExpression || !expectLineEnd(lexer_.peekExpression())) {
    recover();
  }
}

void Parser::parseSymbolList(std::vector<core::SymbolId>& symbols, std::string_view name) {
  reading_ = name;
  while (lexer_.peekPlain().kind == TokenKind::Symbol) {
    symbols.push_back(lexer_.peekPlain().symbol);
    model_.symbolPlaces.push_back({symbols.back(), false, lexer_.peekPlain().range});
    lexer_.advance();
  }
  if (lexer_.peekPlain().kind == TokenKind::Invalid) {
    expected("a symbol", lexer_.peekPlain());
    recover();
  } else if (!expectLineEnd(lexer_.peekPlain())) {
    recover();
  }
}

void Parser::parseItemBlock(Block& block, std::string_view name) {
  reading_ = name;
  // the brace may stand on the next line
  while (lexer_.peekExpression().kind == TokenKind::EndOfLine && !lexer_.nextLineIsIndented()) {
    lexer_.advance();
  }
  if (lexer_.peekExpression().kind != TokenKind::OpenBrace) {
    expected("'{'", lexer_.peekExpression());
    recover();
    return;
  }
  if (block.isPresent) {
    messages_.error(lexer_.peekExpression().range, std::string(name) + " appears twice in one L-system",
                    "put the statements together");
  }
  if (!parseBlock(block) || !expectLineEnd(lexer_.peekSymbol())) {
    recover();
  }
}

// ---- Espalier's own items

void Parser::parseSyntaxItem() {
  lexer_.advance();
  reading_ = "'Syntax:'";
  const Token token = lexer_.peekExpression();
  const bool isTab = token.kind == TokenKind::Identifier && token.text == "tab";
  if (!isTab && !(token.kind == TokenKind::Identifier && token.text == "free")) {
    expected("'free' or 'tab'", token);
    recover();
    return;
  }
  lexer_.advance();
  lexer_.setFreeSyntax(!isTab);
  if (!expectLineEnd(lexer_.peekSymbol())) {
    recover();
  }
}

void Parser::parseModuleItem() {
  lexer_.advance();
  reading_ = "'Module:'";
  bool isGood = parseModuleDeclaration();
  while (isGood && lexer_.peekExpression().kind == TokenKind::Comma) {
    lexer_.advance();
    isGood = parseModuleDeclaration();
  }
  if (!isGood || !expectLineEnd(lexer_.peekExpression())) {
    recover();
  }
}

bool Parser::parseModuleDeclaration() {
  Symbol symbol;
  symbol.isDeclared = true;
  if (lexer_.peekExpression().kind == TokenKind::Question) {
    symbol.isQuery = true;
    lexer_.advance();
  }
  const Token name = lexer_.peekExpression();
  if (name.kind != TokenKind::Identifier) {
    return expected("the name of a module", name, "write 'Module: Apex(age, vigor), Leaf(size)'");
  }
  symbol.name = name.text;
  lexer_.advance();
  if (lexer_.peekExpression().kind == TokenKind::OpenParenthesis) {
    do {
      lexer_.advance();
      const Token parameter = lexer_.peekExpression();
      // `(...)`: any number of parameters
      if (parameter.kind == TokenKind::CloseParenthesis && symbol.parameterNames.empty() && lexer_.takeDots()) {
        symbol.parameterNames = {std::string(kAnyParameters)};
        break;
      }
      if (parameter.kind != TokenKind::Identifier) {
        return expected(
            "a parameter name", parameter,
            parameter.kind == TokenKind::CloseParenthesis ? "a module without parameters has no parentheses" : "");
      }
      symbol.parameterNames.push_back(parameter.text);
      lexer_.advance();
    } while (lexer_.peekExpression().kind == TokenKind::Comma);
    if (!expectExpressionToken(TokenKind::CloseParenthesis, "')'")) {
      return false;
    }
  }
  if (model_.symbols.declaredCount() >= kMostDeclaredNames) {
    messages_.error(name.range, "the model declares more than " + std::to_string(kMostDeclaredNames) + " modules");
    return false;
  }
  core::SymbolId id = core::kNoSymbol;
  if (!model_.symbols.declare(std::move(symbol), &id)) {
    messages_.error(name.range, "the module '" + name.text + "' is declared twice");
  }
  model_.symbolPlaces.push_back({id, true, name.range});
  return true;
}

// ---- define

void Parser::parseDefine(LSystemSyntax& system) {
  reading_ = "'define:'";
  while (lexer_.peekExpression().kind == TokenKind::EndOfLine && !lexer_.nextLineIsIndented()) {
    lexer_.advance();
  }
  if (lexer_.peekExpression().kind != TokenKind::OpenBrace) {
    expected("'{'", lexer_.peekExpression());
    recover();
    return;
  }
  lexer_.advance();
  lexer_.enterBlock();
  bool isGood = true;
  do {
    const Token token = lexer_.peekExpression();
    lexer_.advance();
    if (token.kind == TokenKind::Identifier && token.text == "array") {
      isGood = parseArrays(system);
    } else if (token.kind == TokenKind::Identifier && token.text == "external") {
      isGood = parseExternals(system);
    } else {
      isGood = expected(
          "'array' or 'external'", token,
          token.kind == TokenKind::Identifier ? "plain variables need no definition; assign them in Start" : "");
    }
    isGood = isGood && expectExpressionToken(TokenKind::Semicolon, "';'");
  } while (isGood && lexer_.peekExpression().kind != TokenKind::CloseBrace);
  if (!isGood) {
    recover();
    return;
  }
  lexer_.advance();
  lexer_.leaveBlock();
  if (!expectLineEnd(lexer_.peekSymbol())) {
    recover();
  }
}

bool Parser::parseArrays(LSystemSyntax& system) {
  while (true) {
    ArraySyntax array;
    const Token name = lexer_.peekExpression();
    if (name.kind != TokenKind::Identifier) {
      return expected("the name of an array", name);
    }
    array.name = {name.text, name.range};
    lexer_.advance();
    while (lexer_.peekExpression().kind == TokenKind::OpenBracket) {
      lexer_.advance();
      const ExpressionIndex dimension = parseExpression();
      if (dimension == kNoExpression) {
        return false;
      }
      array.dimensions.push_back(dimension);
      if (!expectExpressionToken(TokenKind::CloseBracket, "']'")) {
        return false;
      }
    }
    if (array.dimensions.empty()) {
      return expected("'['", lexer_.peekExpression(), "an array has a size: 'array w[5];'");
    }
    // uses of the array are no mistake when only its values are
    array.range = {name.range.begin, lexer_.position()};
    system.arrays.push_back(std::move(array));
    if (lexer_.peekExpression().kind == TokenKind::Assign) {
      lexer_.advance();
      if (!parseInitialValues(system.arrays.back().initial)) {
        return false;
      }
      system.arrays.back().range.end = lexer_.position();
    }
    if (lexer_.peekExpression().kind != TokenKind::Comma) {
      return true;
    }
    lexer_.advance();
  }
}

/// The values between `{` and `}`. Braces inside are one mistake, and their values are read.
bool Parser::parseInitialValues(std::vector<ExpressionIndex>& values) {
  if (!expectExpressionToken(TokenKind::OpenBrace, "'{'")) {
    return false;
  }
  bool hasInnerBraces = false;
  std::uint32_t depth = 0;
  while (true) {
    for (; lexer_.peekExpression().kind == TokenKind::OpenBrace; ++depth) {
      if (!std::exchange(hasInnerBraces, true)) {
        expected("an expression", lexer_.peekExpression(),
                 "all values stand in one list, row after row: array a[2][2] = {1, 2, 3, 4};");
      }
      lexer_.advance();
    }
    const ExpressionIndex value = parseExpression();
    if (value == kNoExpression) {
      return false;
    }
    values.push_back(value);
    for (; depth > 0 && lexer_.peekExpression().kind == TokenKind::CloseBrace; --depth) {
      lexer_.advance();
    }
    if (lexer_.peekExpression().kind != TokenKind::Comma) {
      return expectExpressionToken(TokenKind::CloseBrace, "'}'");
    }
    lexer_.advance();
  }
}

bool Parser::parseExternals(LSystemSyntax& system) {
  while (true) {
    const Token name = lexer_.peekExpression();
    if (name.kind != TokenKind::Identifier) {
      return expected("the name of a variable", name);
    }
    system.externals.push_back({name.text, name.range});
    lexer_.advance();
    // names are separated by commas or blanks
    if (lexer_.peekExpression().kind == TokenKind::Comma) {
      lexer_.advance();
    } else if (lexer_.peekExpression().kind != TokenKind::Identifier) {
      return true;
    }
  }
}

}  // namespace espalier::language

#include "engine/language/parser.h"

#include <array>
#include <utility>

namespace espalier::language {
namespace {

bool startsSection(Keyword keyword) {
  return keyword == Keyword::Decomposition || keyword == Keyword::Homomorphism || keyword == Keyword::Endlsystem ||
         keyword == Keyword::Lsystem;
}

}  // namespace

std::string tabHint() {
  return "a line that continues the one before must start with a TAB, not with blanks (or write 'Syntax: free' before the "
         "first L-system)";
}

// ---- messages and recovery

std::string Parser::describeReading() const {
  if (predecessor_.begin == predecessor_.end) {
    return reading_;
  }
  return reading_ + " of " +
         foldBlanks(lexer_.text().substr(predecessor_.begin, predecessor_.end - predecessor_.begin));
}

bool Parser::expected(std::string_view what, const Token& token, std::string hint) {
  if (token.kind == TokenKind::Invalid && !token.hint.empty()) {
    hint = token.hint;
  } else if (token.kind == TokenKind::Invalid && token.text[0] < 0) {
    hint = "models are written in 7-bit ASCII; other characters may stand in comments and strings only";
  } else if (token.kind == TokenKind::EndOfLine && !lexer_.isFreeSyntax() && lexer_.nextLineIsIndented()) {
    hint = tabHint();
    skipsIndentedLines_ = true;
  } else if (token.kind == TokenKind::Keyword && hint.empty()) {
    hint = "these letters are a keyword wherever they stand; blanks between symbols keep them apart";
  }
  messages_.error(token.range, "expected " + std::string(what) + " while reading " + describeReading() + ", found " +
                                   describe(token),
                  std::move(hint));
  return false;
}

bool Parser::expectExpressionToken(TokenKind kind, std::string_view what) {
  const Token& token = lexer_.peekExpression();
  if (token.kind != kind) {
    return expected(what, token);
  }
  lexer_.advance();
  return true;
}

bool Parser::expectLineEnd(const Token& token) {
  if (token.kind == TokenKind::EndOfFile) {
    return true;
  }
  if (token.kind == TokenKind::EndOfLine || (token.kind == TokenKind::Semicolon && lexer_.isFreeSyntax())) {
    lexer_.advance();
    lexer_.setBracketDepth(0);
    return true;
  }
  return expected("the end of the line", token);
}

void Parser::recover() {
  lexer_.skipLine();
  if (skipsIndentedLines_) {
    lexer_.skipIndentedLines();
  }
  skipsIndentedLines_ = false;
  expressionDepth_ = 0;
}

// ---- files and L-systems

void Parser::parseFile() {
  while (true) {
    reading_ = "the model";
    predecessor_ = {};
    const Token& token = lexer_.peekSymbol();
    if (token.kind == TokenKind::EndOfFile) {
      if (model_.systems.empty() && messages_.errorCount() == 0) {
        expected("'Lsystem:'", token, "a model starts with 'Lsystem: 1' and ends with 'endlsystem'");
      }
      return;
    }
    if (token.kind == TokenKind::EndOfLine) {
      lexer_.advance();
    } else if (token.kind == TokenKind::Keyword && token.keyword == Keyword::Lsystem) {
      parseLSystem();
    } else if (token.kind == TokenKind::Keyword && token.keyword == Keyword::Syntax) {
      parseSyntaxItem();
    } else if (token.kind == TokenKind::Keyword && token.keyword == Keyword::Module) {
      parseModuleItem();
    } else {
      expected("'Lsystem:'", token, "every L-system starts with 'Lsystem:' and a label, and ends with 'endlsystem'");
      recover();
      // one message is enough for a text that is no L-system
      while (lexer_.peekSymbol().kind != TokenKind::EndOfFile &&
             !(lexer_.peekSymbol().kind == TokenKind::Keyword && lexer_.peekSymbol().keyword == Keyword::Lsystem)) {
        lexer_.skipLine();
      }
    }
  }
}

void Parser::parseLSystem() {
  LSystemSyntax& system = model_.systems.emplace_back();
  system.range = lexer_.peekSymbol().range;
  lexer_.advance();
  // the label: all characters of the line
  reading_ = "the label of an L-system";
  system.labelRange = {lexer_.position(), lexer_.position()};
  while (lexer_.peekPlain().kind == TokenKind::Symbol) {
    const Token token = lexer_.peekPlain();
    system.labelRange = {system.label.empty() ? token.range.begin : system.labelRange.begin, token.range.end};
    system.label += token.text;
    lexer_.advance();
  }
  if (system.label.empty()) {
    expected("a label", lexer_.peekPlain(), "write 'Lsystem: 1'");
  }
  if (!expectLineEnd(lexer_.peekPlain())) {
    recover();
  }

  parseItems(system);
  parseProductions(system, system.productions, "the productions after the axiom");
  const auto isAt = [&](Keyword keyword) {
    const Token& token = lexer_.peekSymbol();
    return token.kind == TokenKind::Keyword && token.keyword == keyword;
  };
  bool hasHomomorphism = false;
  while (isAt(Keyword::Decomposition) || isAt(Keyword::Homomorphism)) {
    const bool isDecomposition = isAt(Keyword::Decomposition);
    ProductionListSyntax& list = isDecomposition ? system.decomposition : system.homomorphism;
    reading_ = isDecomposition ? "the decomposition" : "the homomorphism";
    if (!list.productions.empty()) {
      messages_.error(lexer_.peekSymbol().range, reading_ + " appears twice in one L-system", "put its productions together");
    } else if (isDecomposition && hasHomomorphism) {
      messages_.error(lexer_.peekSymbol().range, "the decomposition must stand before the homomorphism");
    }
    hasHomomorphism = hasHomomorphism || !isDecomposition;
    parseSectionHead(list);
    parseProductions(system, list, isDecomposition ? "the decomposition" : "the homomorphism");
  }
  reading_ = "the L-system " + system.label;
  predecessor_ = {};
  if (!isAt(Keyword::Endlsystem)) {
    expected("'endlsystem'", lexer_.peekSymbol(), "every L-system ends with a line 'endlsystem'");
    return;
  }
  lexer_.advance();
  if (!expectLineEnd(lexer_.peekSymbol())) {
    recover();
  }
}

void Parser::parseItems(LSystemSyntax& system) {
  bool hasComplained = false;
  while (true) {
    reading_ = "the items of the L-system " + system.label;
    predecessor_ = {};
    const Token& token = lexer_.peekSymbol();
    if (token.kind == TokenKind::EndOfLine) {
      lexer_.advance();
    } else if (token.kind == TokenKind::Keyword && token.keyword == Keyword::Axiom) {
      parseAxiom(system);
      return;
    } else if (token.kind == TokenKind::EndOfFile || (token.kind == TokenKind::Keyword && startsSection(token.keyword))) {
      if (!hasComplained) {
        expected("'Axiom:'", token, "every L-system has an axiom, the string it starts from: 'Axiom: A(1)'");
      }
      return;
    } else if (token.kind == TokenKind::Keyword) {
      parseItem(system);
    } else {
      if (!hasComplained) {
        static const std::vector<std::string_view> kItems{"derivation length", "seed", "consider", "ignore",  "axiom",
                                                          "define",            "start", "end",     "Start each", "End each"};
        const std::string_view rest = lexer_.text().substr(token.range.begin);
        const std::string_view line = rest.substr(0, rest.find('\n'));
        const std::string_view near = core::nearestName(line.substr(0, line.find(':')), kItems);
        std::string hint = "the items come first, then 'Axiom:', then the productions";
        if (line.find(':') != std::string_view::npos && !near.empty()) {
          hint = "did you mean '" + std::string(near) + ":'?";
        } else if (!lexer_.isFreeSyntax() && lexer_.lineIsIndented(token.range.begin)) {
          hint = tabHint();
        }
        expected("an item or 'Axiom:'", token, std::move(hint));
      }
      hasComplained = true;
      recover();
    }
  }
}

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
      if (parameter.kind != TokenKind::Identifier) {
        return expected("a parameter name", parameter,
                        parameter.kind == TokenKind::CloseParenthesis ? "a module without parameters has no parentheses" : "");
      }
      symbol.parameterNames.push_back(parameter.text);
      lexer_.advance();
    } while (lexer_.peekExpression().kind == TokenKind::Comma);
    if (!expectExpressionToken(TokenKind::CloseParenthesis, "')'")) {
      return false;
    }
  }
  core::SymbolId id = core::kNoSymbol;
  if (!model_.symbols.declare(std::move(symbol), &id)) {
    messages_.error(name.range, "the module '" + name.text + "' is declared twice");
  }
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
      isGood = expected("'array' or 'external'", token,
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
    if (lexer_.peekExpression().kind == TokenKind::Assign) {
      lexer_.advance();
      if (!expectExpressionToken(TokenKind::OpenBrace, "'{'")) {
        return false;
      }
      do {
        const ExpressionIndex value = parseExpression();
        if (value == kNoExpression) {
          return false;
        }
        array.initial.push_back(value);
        if (lexer_.peekExpression().kind != TokenKind::Comma) {
          break;
        }
        lexer_.advance();
      } while (true);
      if (!expectExpressionToken(TokenKind::CloseBrace, "'}'")) {
        return false;
      }
    }
    array.range = {name.range.begin, lexer_.position()};
    system.arrays.push_back(std::move(array));
    if (lexer_.peekExpression().kind != TokenKind::Comma) {
      return true;
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

// ---- axiom and sections

void Parser::parseAxiom(LSystemSyntax& system) {
  lexer_.advance();
  reading_ = "the axiom";
  if (!parseModules(system.axiom)) {
    recover();
    return;
  }
  const Token& token = lexer_.peekSymbol();
  if (system.axiom.empty()) {
    expected("a module", token);
    recover();
  } else if (token.kind != TokenKind::EndOfLine && token.kind != TokenKind::EndOfFile) {
    expected("a module", token);
    recover();
  } else if (!expectLineEnd(token)) {
    recover();
  }
}

void Parser::parseSectionHead(ProductionListSyntax& list) {
  lexer_.advance();
  const Token token = lexer_.peekSymbol();
  if (token.kind == TokenKind::Keyword && (token.keyword == Keyword::Warnings || token.keyword == Keyword::NoWarnings)) {
    list.warns = token.keyword == Keyword::Warnings;
    lexer_.advance();
  }
  if (!expectLineEnd(lexer_.peekSymbol())) {
    recover();
  }
}

void Parser::parseProductions(LSystemSyntax& system, ProductionListSyntax& list, std::string_view name) {
  bool hasProduction = false;
  while (true) {
    reading_ = name;
    predecessor_ = {};
    const Token token = lexer_.peekSymbol();
    if (token.kind == TokenKind::EndOfLine) {
      lexer_.advance();
      continue;
    }
    if (token.kind == TokenKind::EndOfFile || (token.kind == TokenKind::Keyword && startsSection(token.keyword))) {
      if (!hasProduction) {
        expected("a production", token, "every list has at least one production, as in 'A --> A'");
      }
      return;
    }
    if (token.kind != TokenKind::Keyword) {
      hasProduction = true;
      parseProduction(list);
    } else if (token.keyword == Keyword::MaximumDepth && &list != &system.productions) {
      lexer_.advance();
      parseValueItem(list.maximumDepth, "'maximum depth:'");
    } else if (token.keyword == Keyword::Seed && &list == &system.homomorphism) {
      lexer_.advance();
      parseValueItem(list.seed, "the homomorphism's 'seed:'");
    } else if (token.keyword == Keyword::Axiom) {
      expected("a production", token, "an L-system has one axiom");
      recover();
    } else {
      expected("a production", token, "this keyword must stand before the axiom");
      parseItem(system);
    }
  }
}

}  // namespace espalier::language

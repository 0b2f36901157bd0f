#include "engine/language/parse/parser.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "engine/language/hexadecimal.h"
#include "engine/language/parse/foreign_lines.h"
#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

bool startsSection(Keyword keyword) {
  return keyword == Keyword::Decomposition || keyword == Keyword::Homomorphism || keyword == Keyword::Endlsystem ||
         keyword == Keyword::Lsystem;
}

}  // namespace

// ---- messages and recovery

std::string Parser::describeReading() const {
  if (predecessor_.begin == predecessor_.end) {
    return reading_;
  }
  return reading_ + " of " +
         foldBlanks(lexer_.text().substr(predecessor_.begin, predecessor_.end - predecessor_.begin));
}

bool Parser::expected(std::string_view what, const Token& token, std::string hint) {
  if (token.kind == TokenKind::EndOfFile && std::exchange(hasReportedEnd_, true)) {
    return false;
  }
  const std::string advice = adviceFor(token);
  if (lexer_.skipsBeforeToken()) {
    const core::SourceRange& range = lexer_.skippedBeforeToken();
    const std::string text(lexer_.text().substr(range.begin, range.end - range.begin));
    const std::string_view command = latexCommand(lexer_.text().substr(range.begin));
    hint = !command.empty() ? latexAdvice(command)
           : text == "." && token.kind == TokenKind::Identifier
               ? "functions are called by their names alone: " + token.text + "(...)"
               : "'" + text + "' before it is skipped: " + (text == "|" ? "write '||' for 'or'" : "remove it");
  } else if (!advice.empty() && (token.kind == TokenKind::Invalid || hint.empty() ||
                                 !hexadecimalHint(lexer_.text(), token.range.begin).empty())) {
    hint = advice;
  } else if (token.kind == TokenKind::EndOfLine &&
             (startsInComment(token.range.end) || (!lexer_.isFreeSyntax() && lexer_.nextLineIsIndented()))) {
    hint = continuationHint(token.range.end);
    skipsIndentedLines_ = true;
  } else if (token.kind == TokenKind::Keyword && hint.empty()) {
    hint = "these letters are a keyword everywhere; put blanks between them to write symbols";
  }
  messages_.error(
      token.range,
      "expected " + std::string(what) + " while reading " + describeReading() + ", found " + describe(token),
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
  do {
    lexer_.skipLine();
  } while (lexer_.position() < lexer_.text().size() && startsInComment(lexer_.position()));
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
      reportSkippedCharacters();
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
      const std::string_view line = lineAt(token.range.begin);
      const bool isBelow = lexer_.text().find("system:", token.range.end) != std::string_view::npos;
      const std::string foreign = foreignLine(line).advice;
      expected("'Lsystem:'", token,
               line.starts_with("define ") || line.starts_with("include ")
                   ? "macros and includes start with '#': #" + std::string(line.substr(0, line.find(' ')))
               : line.starts_with("Lsystem ") || line.starts_with("lsystem ")
                   ? trimBlanks(line.substr(7)).starts_with(':')
                         ? "no blank stands before the ':': write '" + std::string(line.substr(0, 7)) + ":'"
                         : "write a ':' behind 'Lsystem'"
               : isBelow && !foreign.empty() ? foreign
               : token.kind == TokenKind::Keyword && isBelow
                   ? "this line belongs below the line 'Lsystem: 1'"
                   : "every L-system starts with 'Lsystem:' and a label, and ends with 'endlsystem'. In the "
                     "notation of textbooks write 'axiom: F' and 'F -> F+F'");
      recover();
      // one message is enough for a text that is not an L-system
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
  bool hasDecomposition = false;
  bool hasHomomorphism = false;
  while (isAt(Keyword::Decomposition) || isAt(Keyword::Homomorphism)) {
    const bool isDecomposition = isAt(Keyword::Decomposition);
    ProductionListSyntax& list = isDecomposition ? system.decomposition : system.homomorphism;
    reading_ = isDecomposition ? "the decomposition" : "the homomorphism";
    if (isDecomposition ? hasDecomposition : hasHomomorphism) {
      messages_.error(lexer_.peekSymbol().range, reading_ + " appears twice in one L-system",
                      "put its productions together");
    } else if (isDecomposition && hasHomomorphism) {
      messages_.error(lexer_.peekSymbol().range, "the decomposition must stand before the homomorphism");
    }
    (isDecomposition ? hasDecomposition : hasHomomorphism) = true;
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

/// Reports a label that goes on in lines that start with a TAB, which hold the items. False: it does not.
bool Parser::reportsLabelOfLines(const LSystemSyntax& system) {
  const std::size_t newline = lexer_.text().substr(0, system.labelRange.end).find('\n', system.labelRange.begin);
  if (newline == std::string_view::npos) {
    return false;
  }
  const auto begin = static_cast<std::uint32_t>(newline) + 1;
  messages_.error({begin, begin + 1}, "this line starts with a TAB and so continues the label of the L-system",
                  "start every line in column 1");
  hasReportedEnd_ = true;
  return true;
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
    } else if (token.kind == TokenKind::EndOfFile ||
               (token.kind == TokenKind::Keyword && startsSection(token.keyword))) {
      if (!hasComplained && !reportsLabelOfLines(system)) {
        expected("'Axiom:'", token, "every L-system has an axiom, the string it starts from: 'Axiom: A(1)'");
      }
      return;
    } else if (token.kind == TokenKind::Keyword) {
      parseItem(system);
    } else {
      if (!hasComplained) {
        // productions without an axiom give one message; the productions are read
        if (lineAt(token.range.begin).find("-->") != std::string_view::npos) {
          expected("'Axiom:'", token,
                   "every L-system has an axiom before its productions, the string it starts from: 'Axiom: A(1)'");
          return;
        }
        if (const ForeignLine foreign = skipForeignLine("an item or 'Axiom:'", token); !foreign.advice.empty()) {
          if (foreign.isAxiom) {
            return;
          }
          continue;
        }
        static const std::vector<std::string_view> kItems{
            "derivation length", "seed",    "consider", "ignore", "axiom", "define", "start", "end",
            "Start each",        "End each"};
        const std::string_view line = lineAt(token.range.begin);
        const std::string_view word = line.substr(0, line.find(':'));
        std::string lowered(word);
        for (char& c : lowered) {
          c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        }
        const std::string_view near = core::nearestName(lowered, kItems);
        std::string hint = "write the items first, then 'Axiom:', then the productions";
        if (line.find(':') != std::string_view::npos && !near.empty()) {
          // continue behind a misspelt word, so that the next one is reported, too
          Token misspelt = token;
          misspelt.text = word;
          misspelt.range.end = token.range.begin + static_cast<std::uint32_t>(word.size());
          expected("an item or 'Axiom:'", misspelt, "did you mean '" + std::string(near) + ":'?");
          recover();
          if (near == "axiom") {
            return;
          }
          continue;
        }
        const auto unmarked = std::ranges::find_if(
            kItems, [&](std::string_view item) { return lowered.starts_with(std::string(item) + " "); });
        if (unmarked != kItems.end()) {
          const std::size_t next = line.find_first_not_of(" \t", unmarked->size());
          hint = (next != std::string_view::npos && line[next] == '=' ? "write ':' in place of '=' behind '"
                                                                      : "write a ':' behind '") +
                 std::string(line.substr(0, unmarked->size())) + "'";
        }
        if (std::string continued = continuationHint(token.range.begin); !continued.empty()) {
          hint = std::move(continued);
        }
        expected("an item or 'Axiom:'", token, std::move(hint));
      }
      hasComplained = true;
      recover();
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
  const auto text = [this](const ModuleSyntax& module) {
    return lexer_.text().substr(module.range.begin, module.range.end - module.range.begin);
  };
  if (system.axiom.size() > 2 && text(system.axiom.front()) == "\"" && text(system.axiom.back()) == "\"") {
    messages_.warning(system.axiom.front().range, "the quotation marks are read as modules of the axiom",
                      "modules are written without quotes");
  }
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
  if (token.kind == TokenKind::Keyword &&
      (token.keyword == Keyword::Warnings || token.keyword == Keyword::NoWarnings)) {
    list.warns = token.keyword == Keyword::Warnings;
    lexer_.advance();
  }
  if (lexer_.peekSymbol().kind == TokenKind::Symbol) {
    expected("the end of the line", lexer_.peekSymbol(), "the productions begin on the next line");
    recover();
  } else if (!expectLineEnd(lexer_.peekSymbol())) {
    recover();
  }
}

void Parser::parseProductions(LSystemSyntax& system, ProductionListSyntax& list, std::string_view name) {
  while (true) {
    reading_ = name;
    predecessor_ = {};
    const Token token = lexer_.peekSymbol();
    if (token.kind == TokenKind::EndOfLine) {
      lexer_.advance();
      continue;
    }
    if (token.kind == TokenKind::EndOfFile || (token.kind == TokenKind::Keyword && startsSection(token.keyword))) {
      return;  // a list may be empty
    }
    if (token.kind != TokenKind::Keyword) {
      if (!skipsNoProduction(name)) {
        parseProduction(list);
      }
    } else if (token.keyword == Keyword::MaximumDepth && &list != &system.productions) {
      lexer_.advance();
      parseValueItem(list.maximumDepth, "'maximum depth:'");
    } else if (token.keyword == Keyword::Seed && &list == &system.homomorphism) {
      lexer_.advance();
      parseValueItem(list.seed, "the homomorphism's 'seed:'");
    } else if (token.keyword == Keyword::Axiom) {
      expected("a production", token, "an L-system has one axiom");
      recover();
    } else if (token.keyword == Keyword::Warnings || token.keyword == Keyword::NoWarnings) {
      expected("a production", token, "it stands behind 'decomposition' or 'homomorphism', on the same line");
      recover();
    } else {
      expected("a production", token, "this keyword must stand before the axiom");
      parseItem(system);
    }
  }
}

}  // namespace espalier::language

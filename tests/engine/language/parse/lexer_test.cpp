#include "engine/language/parse/lexer.h"

#include <gtest/gtest.h>

namespace espalier::language::lexer_test {
namespace {

// the tokens of a text in symbol mode, separated by blanks
std::string symbols(std::string_view text, bool isFree = false, std::vector<std::string> declared = {}) {
  SymbolTable table;
  for (std::string& name : declared) {
    core::SymbolId id = core::kNoSymbol;
    EXPECT_TRUE(table.declare({std::move(name), true, false, {}}, &id));
  }
  Lexer lexer(text, table);
  lexer.setFreeSyntax(isFree);
  std::string result;
  while (lexer.peekSymbol().kind != TokenKind::EndOfFile) {
    const Token token = lexer.peekSymbol();
    lexer.advance();
    result += result.empty() ? "" : " ";
    result += token.kind == TokenKind::EndOfLine ? "$"
              : token.kind == TokenKind::Keyword ? "<" + token.text + ">"
                                                 : token.text;
  }
  return result;
}

std::vector<Token> expressions(std::string_view text) {
  SymbolTable table;
  Lexer lexer(text, table);
  std::vector<Token> result;
  while (lexer.peekExpression().kind != TokenKind::EndOfFile) {
    result.push_back(lexer.peekExpression());
    lexer.advance();
  }
  return result;
}

TEST(Lexer, EveryCharacterIsASymbol) {
  EXPECT_EQ(symbols(".&|_;{}~!^\\+12@M"), ". & | _ ; { } ~ ! ^ \\ + 1 2 @ M");
}

TEST(Lexer, ArrowsAndContextsAreNoSymbols) {
  EXPECT_EQ(symbols("A << B < C > D >> E : * --> F -o> G"), "A << B < C > D >> E : * --> F -o> G");
  EXPECT_EQ(symbols("F--->G"), "F - --> G");
}

TEST(Lexer, ANewlineEndsUnlessATabFollows) {
  EXPECT_EQ(symbols("A\n\tB\n\t\tC\n D\nE"), "A B C $ D $ E");
}

TEST(Lexer, KeywordsAreFoundEverywhere) {
  EXPECT_EQ(
      symbols(
          "lsystem: 1\nDerivationlength: 2\nderivation length: 3\nRing Lsystem\nStartEach:\nStart Each:\nAwarningsB"),
      "<lsystem:> 1 $ <Derivationlength:> 2 $ <derivation length:> 3 $ <Ring Lsystem> $ <StartEach:> $ <Start Each:> $ "
      "A "
      "<warnings> B");
  EXPECT_EQ(symbols("no warnings\nEndlsystem\nHomomorphism:\nhomomorphism\nseed:\nEnd: EndEach:"),
            "<no warnings> $ <Endlsystem> $ <Homomorphism:> $ <homomorphism> $ <seed:> $ <End:> <EndEach:>");
}

TEST(Lexer, OnlyTheFirstLetterOfAKeywordMayBeUpperCase) {
  EXPECT_EQ(symbols("AXIOM:"), "A X I O M :");
}

TEST(Lexer, DeclaredNamesAreMatchedLongestFirst) {
  EXPECT_EQ(symbols("ApexApX[Ap", false, {"Ap", "Apex"}), "Apex Ap X [ Ap");
}

TEST(Lexer, FreeSyntaxEndsAtColumnOneOrSemicolon) {
  EXPECT_EQ(symbols("A -->\n  B\n\n  C\nD; E ;(2)\n", true), "A --> B C $ D $ E ; ( 2 ) $");
}

TEST(Lexer, OtherCharactersAreInvalid) {
  SymbolTable table;
  Lexer lexer("\xC3\xA4", table);
  EXPECT_EQ(lexer.peekSymbol().kind, TokenKind::Invalid);
  EXPECT_EQ(lexer.peekSymbol().range.end, 2U);
  EXPECT_EQ(describe(lexer.peekSymbol()), "the character '\xC3\xA4', which is not 7-bit ASCII");
}

TEST(Lexer, NumbersHaveAPointBeforeTheirExponent) {
  const std::vector<Token> tokens = expressions("5 .5 5. 1.5e3 2.5E-2 007 3.e+1");
  ASSERT_EQ(tokens.size(), 7U);
  const std::vector<double> values{5.0, 0.5, 5.0, 1500.0, 0.025, 7.0, 30.0};
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(tokens[i].kind, TokenKind::Number) << i;
    EXPECT_EQ(tokens[i].number, values[i]) << i;
  }
}

TEST(Lexer, AnIntegerWithExponentIsNoNumber) {
  const std::vector<Token> tokens = expressions("12e-5");
  ASSERT_EQ(tokens.size(), 1U);
  EXPECT_EQ(tokens[0].kind, TokenKind::Invalid);
  EXPECT_EQ(tokens[0].hint, "an exponent needs a decimal point before it: write 12.0e-5");
}

TEST(Lexer, CharactersThatBeginNoTokenAreSkipped) {
  const std::vector<Token> tokens = expressions("\\_y @#y_2 __ '3.\\,.5` . 7 | 8||9 ~$");
  std::string text;
  for (const Token& token : tokens) {
    text += token.text + " ";
  }
  EXPECT_EQ(text, "y y_2 3. , .5 7 8 || 9 ");
  SymbolTable table;
  Lexer lexer("\\_y _ 1 ~", table);
  EXPECT_EQ(lexer.peekExpression().range.begin, 2U);
  EXPECT_TRUE(lexer.skipsBeforeToken());
  EXPECT_TRUE(lexer.skipped().empty());  // a token that is only looked at may be read in another mode
  lexer.advance();
  static_cast<void>(lexer.peekExpression());
  lexer.advance();
  static_cast<void>(lexer.peekExpression());
  lexer.advance();
  ASSERT_EQ(lexer.skipped().size(), 3U);
  EXPECT_EQ(lexer.skipped()[0].end, 2U);
  EXPECT_EQ(lexer.skipped()[1].begin, 4U);
  EXPECT_EQ(lexer.skipped()[2].begin, 8U);
}

TEST(Lexer, OperatorsAreLongestFirst) {
  std::string text;
  for (const Token& token : expressions("a<=b<>c<d!=!e--f-->g==h=i&&j&k||l")) {
    text += token.text + " ";
  }
  EXPECT_EQ(text, "a <= b <> c < d != ! e - - f --> g == h = i && j & k || l ");
}

TEST(Lexer, StringsReplaceEscapes) {
  const std::vector<Token> tokens = expressions("\"a\\n\\t\\\"\\\\b\" \"open");
  ASSERT_EQ(tokens.size(), 2U);
  EXPECT_EQ(tokens[0].text, "a\n\t\"\\b");
  EXPECT_EQ(tokens[1].kind, TokenKind::Invalid);
  EXPECT_EQ(tokens[1].hint, "the string has no closing '\"' on its line");
}

TEST(Lexer, InsideABlockNewlinesAreBlanks) {
  SymbolTable table;
  Lexer lexer("a\nb", table);
  lexer.enterBlock();
  EXPECT_EQ(lexer.peekExpression().text, "a");
  lexer.advance();
  EXPECT_EQ(lexer.peekExpression().text, "b");
}

}  // namespace
}  // namespace espalier::language::lexer_test

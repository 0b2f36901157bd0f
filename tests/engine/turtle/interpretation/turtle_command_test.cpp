#include "engine/turtle/interpretation/turtle_command.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "engine/turtle/interpretation/symbol_list.h"

namespace espalier::turtle::turtle_command_test {
namespace {

TEST(TurtleCommand, DeclaredNamesHaveNone) {
  EXPECT_EQ(commandOf('\0', 1), TurtleCommand::None);
}

TEST(TurtleCommand, BracketsAndCutsHaveNoParameters) {
  EXPECT_EQ(commandOf('[', 0), TurtleCommand::OpenBranch);
  EXPECT_EQ(commandOf('[', 1), TurtleCommand::None);
  EXPECT_EQ(commandOf(']', 1), TurtleCommand::None);
  EXPECT_EQ(commandOf('%', 0), TurtleCommand::Cut);
  EXPECT_EQ(commandOf('%', 1), TurtleCommand::None);
  EXPECT_EQ(commandOf('$', 0), TurtleCommand::SubSystemEnd);
}

TEST(TurtleCommand, OnlyTwoOrThreeParametersMakeTheLegacyQuery) {
  EXPECT_EQ(commandOf('s', 1), TurtleCommand::None);
  EXPECT_EQ(commandOf('s', 2), TurtleCommand::LegacyPosition);
  EXPECT_EQ(commandOf('s', 3), TurtleCommand::LegacyPosition);
  EXPECT_EQ(commandOf('s', 4), TurtleCommand::None);
}

TEST(TurtleCommand, PairsAfterAtAreExact) {
  EXPECT_EQ(commandAfterAt('G', 's'), TurtleCommand::CylinderStart);
  EXPECT_EQ(commandAfterAt('G', '\0'), TurtleCommand::None);
  EXPECT_EQ(commandAfterAt('D', '\0'), TurtleCommand::SetScale);
  EXPECT_EQ(commandAfterAt('D', 'i'), TurtleCommand::ScaleUp);
  EXPECT_EQ(commandAfterAt('X', '\0'), TurtleCommand::ExchangeFrames);
  EXPECT_EQ(commandAfterAt('z', '\0'), TurtleCommand::None);
  EXPECT_EQ(commandAfterAt('m', 'c'), TurtleCommand::ConditionalCut);
}

// the page and the turtle read the same rows
TEST(TurtleCommand, EachSymbolOfThePageIsObeyed) {
  std::set<std::string> texts;
  for (const SymbolInfo& symbol : allSymbols()) {
    const std::string text = symbol.text;
    EXPECT_TRUE(texts.insert(text).second) << text << " has two rows";
    EXPECT_NE(std::string(symbol.usage).find(text), std::string::npos) << text;
    EXPECT_NE(std::string(symbol.meaning), "") << text;
    if (text.size() > 1) {
      ASSERT_EQ(text[0], '@');
      EXPECT_NE(commandAfterAt(text[1], text.size() > 2 ? text[2] : '\0'), TurtleCommand::None) << text;
      EXPECT_EQ(text.size() > 2, text.size() > 2 && takesSecondSymbol(text[1])) << text;
    } else {
      EXPECT_TRUE(commandOf(text[0], 0) != TurtleCommand::None || commandOf(text[0], 2) != TurtleCommand::None) << text;
    }
  }
  EXPECT_GT(texts.size(), 60U);
}

TEST(TurtleCommand, SixLettersTakeASecondSymbol) {
  for (const char c : {'P', 'T', 'G', 'm', 'D', 'b'}) {
    EXPECT_TRUE(takesSecondSymbol(c)) << c;
  }
  EXPECT_FALSE(takesSecondSymbol('M'));
  EXPECT_FALSE(takesSecondSymbol('\0'));
}

}  // namespace
}  // namespace espalier::turtle::turtle_command_test

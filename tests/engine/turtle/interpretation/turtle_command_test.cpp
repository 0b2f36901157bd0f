#include "engine/turtle/interpretation/turtle_command.h"

#include <gtest/gtest.h>

namespace espalier::turtle {
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

TEST(TurtleCommand, SixLettersTakeASecondSymbol) {
  for (const char c : {'P', 'T', 'G', 'm', 'D', 'b'}) {
    EXPECT_TRUE(takesSecondSymbol(c)) << c;
  }
  EXPECT_FALSE(takesSecondSymbol('M'));
  EXPECT_FALSE(takesSecondSymbol('\0'));
}

}  // namespace
}  // namespace espalier::turtle

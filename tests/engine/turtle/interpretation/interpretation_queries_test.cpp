#include "engine/turtle/interpretation/interpretation.h"
#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::interpretation_queries_test {
namespace {

TEST(InterpretationQueries, FillOnlyAsManyParametersAsThereAre) {
  // recorded
  TurtleRun run("F(3)+(60)F(2)?P?P(9)?H(9,9)?U(9,9,9)?P(9,9,9,9)?L(9,9,9,9,9)?H");
  run.pass();
  EXPECT_EQ(run.text(),
            "F(3)+(60)F(2)?P?P(-1.73205)?H(-0.866025,0.5)?U(0,0,-1)?P(-1.73205,4,0,9)?L(-0.5,-0.866025,0,9,9)?H");
}

TEST(InterpretationQueries, RecordedQuaternion) {
  TurtleRun run("?Q(0,0,0,0)+(90)?Q(0,0,0,0)&(30)?Q(0,0,0,0)/(45)F?Q(9,9)", {}, core::Compatibility::Cpfg);
  run.pass();
  expectParameters(run.parametersOf(1), {0.707107, 0.707107, 0, 0});
  expectParameters(run.parametersOf(4), {1, 0, 0, 0});
  expectParameters(run.parametersOf(7), {0.965926, 0, -0.258819, 0});
  expectParameters(run.lastParameters(), {0.812244, 0});
}

TEST(InterpretationQueries, TheFrameQueryIsEspaliersOwn) {
  TurtleRun own("F+(90)?F(0,0,0,0,0,0,0,0,0,0,0,0)");
  own.pass();
  expectParameters(own.lastParameters(), {0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, -1});
  // in the compatible modes `?F` is a `?` and an F that moves
  TurtleRun reference("?F(2)?P(0,0)", {}, core::Compatibility::Cpfg);
  reference.pass();
  expectParameters(reference.lastParameters(), {0, 2});
}

TEST(InterpretationQueries, StoredValuesAreFloatsInTheCompatibleModesOnly) {
  TurtleRun exact("F(0.1)?P(0,0)");
  exact.pass();
  EXPECT_EQ(exact.lastParameters()[1], 0.1);
  TurtleRun rounded("F(0.1)?P(0,0)", {}, core::Compatibility::Cpfg);
  rounded.pass();
  EXPECT_EQ(rounded.lastParameters()[1], static_cast<double>(0.1F));
}

TEST(InterpretationQueries, TheLegacyQueryWorksInCompatibleEnvironmentPassesOnly) {
  const std::string text = "F(3)s(7)s(7,7)s(7,7,7)s(7,7,7,7)?P(0,0)";
  TurtleRun reference(text, {}, core::Compatibility::Cpfg);
  reference.draw();
  EXPECT_EQ(reference.text(), "F(3)s(7)s(7,7)s(7,7,7)s(7,7,7,7)?P(0,3)");
  reference.pass();
  EXPECT_EQ(reference.text(), "F(3)s(7)s(0,3)s(0,3,0)s(7,7,7,7)?P(0,3)");
  TurtleRun own(text);
  own.pass();
  EXPECT_EQ(own.text(), "F(3)s(7)s(7,7)s(7,7,7)s(7,7,7,7)?P(0,3)");
}

TEST(InterpretationQueries, FillingCanBeSwitchedOff) {
  TurtleRun run("F?P(9,9)");
  run.interpret({}, {.scene = &run.scene, .queryParameterOffsets = nullptr, .fillsQueries = false});
  EXPECT_EQ(run.text(), "F?P(9,9)");
}

TEST(InterpretationQueries, ChangesTellHowToUndoTheFilling) {
  TurtleRun run("F?P(7,8)");
  run.pass();
  ASSERT_EQ(run.changes.size(), 2U);
  EXPECT_EQ(run.changes[0].offset, 0U);
  EXPECT_EQ(run.changes[0].before, 7.0);
  EXPECT_EQ(run.changes[1].before, 8.0);
}

TEST(InterpretationQueries, CommunicationModulesAreCollectedWithTheirTurtleState) {
  TurtleRun run("F(2)?E(1,2)[+(90)F?E(3)]?Light(4)A(5)", {}, core::Compatibility::Espalier, {"Light"});
  run.pass({.position = true,
            .heading = true,
            .left = true,
            .up = true,
            .width = true,
            .scale = true,
            .parameters = true,
            .following = true,
            .geometry = false});
  const QueryBatch& batch = run.queries;
  ASSERT_EQ(batch.size(), 3U);
  EXPECT_EQ(batch.module, (std::vector<std::uint64_t>{2, 7, 10}));
  EXPECT_EQ(run.program.symbols[batch.symbol[0]].name, "E");
  EXPECT_EQ(run.program.symbols[batch.symbol[2]].name, "Light");
  EXPECT_EQ(batch.parameters, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(batch.parameterOffset, (std::vector<std::uint64_t>{0, 2, 3, 4}));
  expectVector(batch.position[1], -1, 2, 0);
  expectVector(batch.heading[1], -1, 0, 0);
  expectVector(batch.up[1], 0, 0, -1);
  EXPECT_EQ(run.offsets, (std::vector<std::uint64_t>{1, 4, 5}));
  // the following modules: [ ] A(5)
  EXPECT_EQ(run.program.symbols[batch.following[0]].name, "[");
  EXPECT_EQ(run.program.symbols[batch.following[1]].name, "]");
  EXPECT_EQ(run.program.symbols[batch.following[2]].name, "A");
  EXPECT_EQ(batch.followingParametersOf(2)[0], 5.0);
  EXPECT_TRUE(batch.followingParametersOf(0).empty());
}

TEST(InterpretationQueries, WhatIsNotNeededIsNotFilled) {
  TurtleRun run("F?E(1)");
  run.pass({.position = true});
  EXPECT_EQ(run.queries.position.size(), 1U);
  EXPECT_TRUE(run.queries.heading.empty());
  EXPECT_TRUE(run.queries.following.empty());
  EXPECT_EQ(run.queries.parameterOffset.size(), 2U);
}

TEST(InterpretationQueries, OfAPairTheSecondSymbolFollows) {
  TurtleRun run("?E(1)~l(2,3)?E(1)@Gs?E(1)");
  run.pass({.following = true});
  EXPECT_EQ(run.program.symbols[run.queries.following[0]].name, "l");
  EXPECT_EQ(run.queries.followingParametersOf(0).size(), 2U);
  EXPECT_EQ(run.program.symbols[run.queries.following[1]].name, "G");
  EXPECT_EQ(run.queries.following[2], core::kNoSymbol);
  EXPECT_EQ(run.queries.followingPair, (std::vector<char>{'~', '@', '\0'}));
  // a module with parameters is no first part of a pair
  TurtleRun other("?E(1)@(3)?E(1)F?E(1)@");
  other.pass({.following = true});
  EXPECT_EQ(other.queries.followingPair, (std::vector<char>{'\0', '\0', '\0'}));
}

// in the compatible pass the width that is sent is the initial one, times the scale of sub-L-systems
TEST(InterpretationQueries, TheCompatiblePassDoesNotExecuteWidths) {
  const std::string text = "!(3)?E(1)?(2,0.5)#(9)?E(1)$";
  TurtleRun reference(text, {}, core::Compatibility::Cpfg);
  reference.pass({.width = true});
  EXPECT_EQ(reference.queries.width, (std::vector<double>{1.0, 0.5}));
  TurtleRun own(text);
  own.pass({.width = true});
  EXPECT_EQ(own.queries.width, (std::vector<double>{3.0, 4.5}));
}

TEST(InterpretationQueries, AQuestionMarkBeforeAnotherSymbolStandsAlone) {
  TurtleRun run("?AF?P(0,0)?");
  run.pass();
  expectParameters(run.parametersOf(4), {0, 1});
  EXPECT_EQ(run.queries.size(), 0U);
}

TEST(InterpretationQueries, TooManyAreAFailureThatNamesTheLimit) {
  TurtleRun run("?E(1)?E(1)");
  run.limits.maximumQueries = 1;
  try {
    run.pass();
    FAIL() << "no failure";
  } catch (const core::SimulationFailure& failure) {
    EXPECT_EQ(failure.error().message,
              "step 1, plant 0, module 2 ('?'): more than 1 communication modules in one step, the limit queries. "
              "Raise the limit if the model is meant to do this.");
  }
}

TEST(ReplyBatch, DropsAndCountsSurplusValues) {
  TurtleRun run("?E(1)?E(1,2)");
  run.pass();
  ReplyBatch replies;
  replies.prepare(run.queries);
  replies.set(run.queries, 0, 0, 5.0);
  replies.set(run.queries, 0, 1, 6.0);
  replies.set(run.queries, 1, 1, 7.0);
  EXPECT_EQ(replies.values, (std::vector<double>{5, 0, 7}));
  EXPECT_EQ(replies.isSet, (std::vector<std::uint8_t>{1, 0, 1}));
  EXPECT_EQ(replies.surplusCount, 1U);
  // the next step begins with nothing
  replies.prepare(run.queries);
  EXPECT_EQ(replies.values, std::vector<double>(3, 0.0));
  EXPECT_EQ(replies.isSet, std::vector<std::uint8_t>(3, 0));
  EXPECT_EQ(replies.surplusCount, 0U);
}

}  // namespace
}  // namespace espalier::turtle::interpretation_queries_test

#include "engine/turtle/interpretation/interpretation.h"

#include <limits>

#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::interpretation_test {
namespace {

files::ViewSettings withAngle(double degrees) {
  files::ViewSettings view;
  view.angleIncrementDegrees = degrees;
  return view;
}

std::vector<double> positionAfter(const std::string& text, files::ViewSettings view = {}) {
  TurtleRun run(text + "?P(0,0,0)", std::move(view));
  run.pass();
  return run.lastParameters();
}

TEST(Interpretation, MovesForwardByTheParameterOrOne) {
  expectParameters(positionAfter("F"), {0, 1, 0});
  expectParameters(positionAfter("F(2)G(3)f(0.5)g"), {0, 6.5, 0});
  expectParameters(positionAfter("F(-1.5)"), {0, -1.5, 0});
}

TEST(Interpretation, TurnsUseTheAngleIncrementWithoutAParameter) {
  expectParameters(positionAfter("+F", withAngle(90)), {-1, 0, 0});
  expectParameters(positionAfter("-F", withAngle(90)), {1, 0, 0});
  expectParameters(positionAfter("&F", withAngle(90)), {0, 0, -1});
  expectParameters(positionAfter("^F", withAngle(90)), {0, 0, 1});
  expectParameters(positionAfter("/+F", withAngle(90)), {0, 0, -1});
  expectParameters(positionAfter("\\+F", withAngle(90)), {0, 0, 1});
  expectParameters(positionAfter("|F"), {0, -1, 0});
  expectParameters(positionAfter("+F"), {-0.7071068, 0.7071068, 0});
}

// recorded: yaw with and without a parameter, angle increment 25
TEST(Interpretation, RecordedYaw) {
  expectParameters(positionAfter("+F-F--F", withAngle(25)), {0.343426, 2.5491, 0});
  expectParameters(positionAfter("+F-F--F+(10)F-(-35)F+(400)F", withAngle(25)), {0.499793, 5.13049, 0});
}

TEST(Interpretation, BracketsRestoreTheWholeTurtle) {
  expectParameters(positionAfter("F[+(90)F(3)@D(5)!(7)]F"), {0, 2, 0});
}

TEST(Interpretation, AClosingBracketWithoutAnOpenOneIsIgnored) {
  expectParameters(positionAfter("F]F"), {0, 2, 0});
}

TEST(Interpretation, ScaleCommandsSetMultiplyAndDivide) {
  files::ViewSettings view;
  view.scaleMultiplier = 0.5;
  // recorded: 1, +3, +6, [ ], +1.5, +0.75, +1.5, +1
  expectParameters(positionAfter("F@D(3)F@Di(2)F[@Dd(12)F]@Dd(4)F@Di F@Dd F@D(1)F", view), {0, 14.75, 0});
}

TEST(Interpretation, InitialScaleMultipliesLengthsButNotPositions) {
  files::ViewSettings view = withAngle(90);
  view.initialScale = 2.5;
  expectParameters(positionAfter("F+f(2)@M(1,1,1)G", view), {-1.5, 1, 1});
}

TEST(Interpretation, DividingTheScaleByZeroIsReportedAndIgnored) {
  TurtleRun run("@Dd(0)F?P(0,0)");
  run.pass();
  expectParameters(run.lastParameters(), {0, 1});
  ASSERT_EQ(run.messages.size(), 1U);
  EXPECT_EQ(run.messages[0], "'@Dd(0)' would divide the turtle's scale by 0 and is ignored");
}

TEST(Interpretation, SetPositionTakesTwoOrThreeCoordinates) {
  expectParameters(positionAfter("F@M(2,-1)"), {2, -1, 0});
  expectParameters(positionAfter("F@M(2,-1,4)"), {2, -1, 4});
}

// recorded: headings with and without an up vector
TEST(Interpretation, RecordedSetHeading) {
  TurtleRun run("@R(1,0,0)?L(0,0,0)+F@R(0,0,2)?U(0,0,0)@R(1,1,0,0,0,1)?L(0,0,0)&F@R(3,4)?U(0,0,0)", withAngle(90));
  run.pass();
  expectParameters(run.parametersOf(3), {0, 1, 0});
  expectParameters(run.parametersOf(9), {0, 1, 0});
  expectParameters(run.parametersOf(13), {0.707107, -0.707107, 0});
  expectParameters(run.lastParameters(), {-0.113137, 0.0848528, 0.989949});
}

// recorded: @v after &(40)/(70)+(20)
TEST(Interpretation, RecordedRollToVertical) {
  TurtleRun run("&(40)/(70)+(20)@v?L(0,0,0)?U(0,0,0)");
  run.pass();
  expectParameters(run.parametersOf(6), {-0.990668, 0, 0.136301});
  expectParameters(run.lastParameters(), {-0.0699574, -0.858234, -0.508468});
}

TEST(Interpretation, TheTurtleHasASecondOrientation) {
  // each has turns of its own, and brackets bring both back
  expectParameters(positionAfter("@X+(90)@X F@X F@X F"), {-1, 2, 0});
  expectParameters(positionAfter("@X+(90)[-(90)@X+(180)F]F@X F"), {-1, 1, 0});
  // both begin as the view file says
  files::ViewSettings view;
  view.initialHeading = {1.0, 0.0, 0.0};
  expectParameters(positionAfter("F@X F", view), {2, 0, 0});
}

TEST(Interpretation, OtherDialectsHaveCommandsOfTheirOwn) {
  // @A multiplies the angle of turns without a parameter, and brackets bring it back
  files::ViewSettings view;
  view.angleIncrementDegrees = 45.0;
  expectParameters(positionAfter("[@A(3)+F]@A(2)+F", view), {-1, 0, 0});
  // @Z turns about the z axis, also for a turtle on its back
  expectParameters(positionAfter("@Z(90)F", view), {-1, 0, 0});
  expectParameters(positionAfter("/(180)@Z(-90)F", view), {1, 0, 0});
  // @B turns from +x towards -y by the angle in radians times the sine
  const double angle = 0.2;
  expectParameters(positionAfter("-(90)@B(0.2)F", view), {std::cos(angle), -std::sin(angle), 0});
  expectParameters(positionAfter("@B(0.2)F", view), {0, 1, 0});
}

TEST(Interpretation, TheSecondOrientationIsNoneOfTheReferences) {
  TurtleRun run("@X F?P(0,0,0)", {}, core::Compatibility::Cpfg);
  run.pass();
  expectParameters(run.lastParameters(), {0, 1, 0});
  ASSERT_EQ(run.messages.size(), 1U);
  EXPECT_EQ(run.messages[0], "the turtle has no command '@X': the symbols after the '@' are interpreted on their own");
}

TEST(Interpretation, WidthColourAndShapesDoNotMove) {
  expectParameters(
      positionAfter("F!(3)#(0.5);(4),(2);,#!@O(2)@o(1)@c(3){.}x_(0.3)@Gs@Gc(3)@Ge@!(5)@#(1)@Gt(1,1)@Gr(0)@Tx(0)"),
      {0, 1, 0});
}

TEST(Interpretation, AnUnknownSymbolAfterAtIsInterpretedOnItsOwn) {
  TurtleRun run("F@zF@F+F@Tz F?P(0,0)", withAngle(90));
  run.pass();
  expectParameters(run.lastParameters(), {-2, 3});
  ASSERT_EQ(run.messages.size(), 3U);
  EXPECT_EQ(run.messages[0], "the turtle has no command '@z': the symbols after the '@' are interpreted on their own");
  EXPECT_EQ(run.messages[1], "the turtle has no command '@F': the symbols after the '@' are interpreted on their own");
  EXPECT_EQ(run.messages[2], "the turtle has no command '@Tz': the symbols after the '@' are interpreted on their own");
}

TEST(Interpretation, ACommandThatTheCompilerHasNamedIsNotNamedAgain) {
  TurtleRun run("@z@y@Tz@Ty");
  run.program.reportedCommands = {"z", "Tz"};
  run.draw();
  ASSERT_EQ(run.messages.size(), 2U);
  EXPECT_EQ(run.messages[0], "the turtle has no command '@y': the symbols after the '@' are interpreted on their own");
  EXPECT_EQ(run.messages[1], "the turtle has no command '@Ty': the symbols after the '@' are interpreted on their own");
}

TEST(Interpretation, AWarningIsGivenOnce) {
  TurtleRun run("@z@z@z@");
  run.draw();
  EXPECT_EQ(run.messages.size(), 2U);
}

TEST(Interpretation, SystemCallsAreRefused) {
  TurtleRun run("@S(1)F?P(0,0)");
  run.pass();
  expectParameters(run.lastParameters(), {0, 1});
  ASSERT_EQ(run.messages.size(), 1U);
  EXPECT_EQ(run.messages[0], "'@S' would run a command of the operating system: Espalier refuses it");
}

TEST(Interpretation, SubSystemCallsScaleUntilTheirEnd) {
  // recorded: 1, then 0.5, then 1 again; nested factors multiply
  expectParameters(positionAfter("F?(7,0.5)F$F"), {0, 2.5, 0});
  expectParameters(positionAfter("?(7,0.5)F?(8,0.5)F$F$F"), {0, 2.25, 0});
}

TEST(Interpretation, ASubSystemScalesTheLineWidthToo) {
  TurtleRun run("!(2)?(7,0.5)F$F");
  run.draw();
  ASSERT_EQ(run.scene.segments.size(), 2U);
  EXPECT_EQ(run.scene.segments[0].endWidth, 1.0);
  EXPECT_EQ(run.scene.segments[1].endWidth, 2.0);
}

TEST(Interpretation, PastACutIsInterpretedUnlessTheViewFileSaysNo) {
  TurtleRun with("F[%F?P(9,9)]F%F?P(9,9)");
  with.pass();
  expectParameters(with.parametersOf(5), {0, 2});
  expectParameters(with.lastParameters(), {0, 3});
  files::ViewSettings view;
  view.interpretsPastCut = false;
  TurtleRun without("F[%F?P(9,9)]F?P(9,9)%F?P(9,9)", view);
  without.pass();
  EXPECT_EQ(without.text(), "F[%F?P(9,9)]F?P(0,2)%F?P(9,9)");
  TurtleRun nested("F[%F[F]F]F?P(9,9)@mc(1)F[F]?P(8,8)", view);
  nested.pass();
  EXPECT_EQ(nested.text(), "F[%F[F]F]F?P(0,2)@mc(1)F[F]?P(8,8)");
}

TEST(Interpretation, ACutInASubSystemEndsAtItsDollar) {
  files::ViewSettings view;
  view.interpretsPastCut = false;
  TurtleRun run("?(2)F%F?(3)F$F$F?P(0,0)", view);
  run.pass();
  expectParameters(run.lastParameters(), {0, 2});
}

TEST(Interpretation, ASurfaceMovesToItsEndPointByTheFirstFactor) {
  files::ViewSettings view;
  files::Surface surface;
  surface.id = 'p';
  surface.endPoint = {-0.5, 1.0, -0.25};  // along L, H, U; at the start L = -x, U = -z
  view.surfaces.push_back(surface);
  // recorded: F~p(1) is at (0.5,2,0.25)
  expectParameters(positionAfter("F~p(1)", view), {0.5, 2, 0.25});
  expectParameters(positionAfter("F~p(1)~p(2)F+(90)~p(1,2,3)@D(3)~p(2,5,7)~p", view), {-8.5, 10, 3.25});
  TurtleRun run("~p(2,3,4)~p(0)~q(1)", view);
  run.draw();
  ASSERT_EQ(run.scene.surfaces.size(), 1U);
  EXPECT_EQ(run.scene.surfaces[0].scale, (core::Vec3{2, 3, 4}));
  EXPECT_TRUE(run.messages.empty());
}

TEST(Interpretation, ATextureThatTheViewFileDoesNotHaveIsSaidOnce) {
  files::ViewSettings view;
  view.textures.emplace_back();
  TurtleRun run("@Tx(1)F@Tx(0)F@Tx(2)F[@Tx(2)F]", view);
  run.draw();
  EXPECT_EQ(run.messages,
            std::vector<std::string>{"there is no texture 2 for '@Tx' in the view file; parts with it are plain"});
}

TEST(Interpretation, ATriangleSurfaceDoesNotMove) {
  files::ViewSettings view;
  view.triangleSurfaces.push_back({.id = 't', .file = "", .triangles = {}});
  expectParameters(positionAfter("F~t(4)F", view), {0, 2, 0});
}

TEST(Interpretation, APlantIsInterpretedInItsOwnCoordinates) {
  // placed at (10,0,5) and turned by a quarter about +y: the plant's +x is the world's -z
  const PlantPlacement placement{.position = {10, 0, 5}, .frame = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}};
  TurtleRun run("F@M(2,3,0)F?P(0,0,0)?H(0,0,0)?E(0)");
  run.pass({.position = true}, placement);
  expectParameters(run.parametersOf(5), {2, 4, 0});
  expectParameters(run.parametersOf(7), {0, 1, 0});
  ASSERT_EQ(run.queries.position.size(), 1U);
  expectVector(run.queries.position[0], 10, 4, 3);
}

TEST(Interpretation, ANonFinitePositionIsAFailureThatNamesTheModule) {
  TurtleRun run("F@D(1)F");
  run.state.step = 4;
  run.state.string.append(run.state.string.types()[0], {});
  run.program.view.initialScale = std::numeric_limits<double>::infinity();
  try {
    run.draw();
    FAIL() << "no failure";
  } catch (const core::SimulationFailure& failure) {
    EXPECT_EQ(failure.error().code, core::SimulationErrorCode::NonFinite);
    EXPECT_EQ(failure.error().message,
              "step 5, plant 0, module 0 ('F'): the turtle's position became (nan, inf, nan) while interpreting. Bound "
              "the lengths and scales of the model.");
    EXPECT_EQ(failure.error().module, 0U);
  }
}

TEST(Interpretation, AnOrganOfInfiniteSizeOrWithoutDirectionIsAFailureThatNamesTheModule) {
  const auto messageOf = [](TurtleRun& run, const PlantPlacement& placement) -> std::string {
    try {
      run.draw(placement);
    } catch (const core::SimulationFailure& failure) {
      return failure.error().message;
    }
    return "no failure";
  };
  const std::string size = " of what it draws is not finite. Bound the angles and scales of the model.";
  TurtleRun ball("@D(1e300)@Di(1e300)@O(1)");
  EXPECT_EQ(messageOf(ball, {}), "step 1, plant 0, module 5 ('@'): the size" + size);
  TurtleRun cylinder("@Gs");
  PlantPlacement placement;
  placement.frame.left.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(messageOf(cylinder, placement), "step 1, plant 0, module 0 ('@'): the direction" + size);
  TurtleRun width("@D(1e300)#(1e300)F");
  EXPECT_EQ(messageOf(width, {}),
            "step 1, plant 0, module 2 ('#'): the line width became infinite. Bound the widths of the model.");
}

TEST(Interpretation, TooManyOpenBracketsAreAFailureThatNamesTheLimit) {
  TurtleRun run("[[[F");
  run.limits.maximumTurtleStack = 2;
  try {
    run.draw();
    FAIL() << "no failure";
  } catch (const core::SimulationFailure& failure) {
    EXPECT_EQ(failure.error().code, core::SimulationErrorCode::LimitExceeded);
    EXPECT_EQ(failure.error().message,
              "step 1, plant 0, module 2 ('['): more than 2 brackets are open, the limit turtleStack. Raise the "
              "limit if the model is meant to do this.");
  }
}

TEST(Interpretation, CanBeCancelled) {
  TurtleRun run("F");
  const std::atomic<bool> cancelled{true};
  run.cancelled = &cancelled;
  try {
    run.draw();
    FAIL() << "no failure";
  } catch (const core::SimulationFailure& failure) {
    EXPECT_EQ(failure.error().code, core::SimulationErrorCode::Cancelled);
  }
}

TEST(Interpretation, RecordsTellWhatMovedDrewOrAsked) {
  TurtleRun run("F+A[F(2)@O(1)]?E(7)@M(1,1)");
  run.draw();
  ASSERT_EQ(run.records.size(), 5U);
  EXPECT_EQ(run.records[0].module, 0U);
  EXPECT_EQ(run.records[0].parent, kNoParent);
  EXPECT_EQ(run.records[1].module, 4U);
  EXPECT_EQ(run.records[1].branchOrder, 1U);
  EXPECT_EQ(run.records[1].parent, 0U);
  EXPECT_EQ(run.records[1].parameters, std::vector<double>{2});
  // the second symbol of a pair is the record's
  EXPECT_EQ(run.records[2].module, 6U);
  EXPECT_EQ(run.program.symbols[run.records[2].symbol].name, "O");
  EXPECT_EQ(run.records[2].parent, 1U);
  // after the branch the axis goes on
  EXPECT_EQ(run.records[3].module, 9U);
  EXPECT_EQ(run.records[3].parent, 0U);
  EXPECT_EQ(run.records[3].parameters, std::vector<double>{7});
  EXPECT_EQ(run.records[4].module, 11U);
  EXPECT_EQ(run.records[4].position, (core::Vec3{1, 1, 0}));
}

// a string with a cut does not tell the count of its lines: the walk forecasts it, wrongly in two of these
TEST(Interpretation, LinesAndRecordsAreTheSameWhereverTheyLieInALongString) {
  constexpr std::size_t kLines = 250'000;  // 40 MB
  std::string lines(kLines, 'F');
  std::string bare;
  for (std::size_t i = 0; i < kLines / 2; ++i) {
    bare += "A]";
  }
  std::string mixed;
  for (std::size_t i = 0; i < kLines / 2; ++i) {
    mixed += "FFA]";
  }
  for (const std::string& text : {lines + bare, bare + lines, mixed}) {
    for (const unsigned threads : {1U, 2U}) {
      TurtleRun run(text + "[%]F");
      run.threads = threads;
      run.draw();
      ASSERT_EQ(run.scene.segments.size(), kLines + 1);
      ASSERT_EQ(run.records.size(), kLines + 1);
      for (std::size_t i = 0; i <= kLines; ++i) {
        ASSERT_EQ(run.scene.segments[i].end.y, static_cast<double>(i + 1));
        ASSERT_EQ(run.records[i].position.y, static_cast<double>(i + 1));
      }
    }
  }
}

TEST(Interpretation, WholeNumberTruncatesAndRejectsWhatNoIntHolds) {
  EXPECT_EQ(wholeNumber(2.9), 2);
  EXPECT_EQ(wholeNumber(-2.9), -2);
  EXPECT_EQ(wholeNumber(1e300), 0);
  EXPECT_EQ(wholeNumber(std::numeric_limits<double>::quiet_NaN()), 0);
}

}  // namespace
}  // namespace espalier::turtle::interpretation_test

#include "engine/turtle/interpretation/drawing.h"

#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::drawing_test {
namespace {

TEST(Drawing, SegmentsKnowTheirParentsModulesAndOrders) {
  TurtleRun run("F[+F[-F]]f F");
  run.draw();
  ASSERT_EQ(run.scene.segments.size(), 4U);
  EXPECT_EQ(run.scene.segments[0].parent, kNoParent);
  EXPECT_EQ(run.scene.segments[1].parent, 0U);
  EXPECT_EQ(run.scene.segments[2].parent, 1U);
  EXPECT_EQ(run.scene.segments[2].branchOrder, 2U);
  EXPECT_EQ(run.scene.segments[2].module, 6U);
  EXPECT_EQ(run.scene.segments[3].parent, 0U);
  expectVector(run.scene.segments[3].start, 0, 2, 0);
}

TEST(Drawing, TaperedLinesBeginWithTheWidthOfTheLineTheyContinue) {
  TurtleRun run("!(3)F!(2)F[!(1)F]");
  run.draw();
  EXPECT_EQ(run.scene.segments[0].startWidth, 3.0);
  EXPECT_EQ(run.scene.segments[1].startWidth, 3.0);
  EXPECT_EQ(run.scene.segments[1].endWidth, 2.0);
  // a side branch has its own width from its base
  EXPECT_EQ(run.scene.segments[2].startWidth, 1.0);
  files::ViewSettings view;
  view.hasTaperedLines = false;
  TurtleRun even("!(3)F!(2)F", view);
  even.draw();
  EXPECT_EQ(even.scene.segments[1].startWidth, 2.0);
}

TEST(Drawing, WidthsChangeByTheIncrementAndStayPositive) {
  files::ViewSettings view;
  view.initialLineWidth = 2.0;
  view.lineWidthIncrement = 0.5;
  TurtleRun run("F#F!!F!(-4)F@D(2)!(3)F", view);
  run.draw();
  EXPECT_EQ(run.scene.segments[0].endWidth, 2.0);
  EXPECT_EQ(run.scene.segments[1].endWidth, 2.5);
  EXPECT_EQ(run.scene.segments[2].endWidth, 1.5);
  EXPECT_EQ(run.scene.segments[3].endWidth, 1e-7);
  EXPECT_EQ(run.scene.segments[4].endWidth, 6.0);
}

TEST(Drawing, ColoursAreSetSteppedAndWrapped) {
  files::ViewSettings view;
  view.colourIncrement = 10;
  TurtleRun run("F;F,,F;(300)F,(-1)F@;(3)F", view);
  run.draw();
  const auto colour = [&](std::size_t i) { return run.scene.segments[i].colour; };
  EXPECT_EQ(colour(0), 128);
  EXPECT_EQ(colour(1), 138);
  EXPECT_EQ(colour(2), 118);
  EXPECT_EQ(colour(3), 44);
  EXPECT_EQ(colour(4), 255);
  EXPECT_EQ(colour(5), 255);
}

TEST(Drawing, PolygonsCollectTheirVertices) {
  files::ViewSettings view;
  view.angleIncrementDegrees = 90;
  TurtleRun run("{.f+f+f}{F G f}", view);
  run.draw();
  ASSERT_EQ(run.scene.polygons.size(), 1U);
  ASSERT_EQ(run.scene.polygons[0].vertices.size(), 4U);
  expectVector(run.scene.polygons[0].vertices[3], -1, 0, 0);
  EXPECT_EQ(run.scene.polygons[0].module, 0U);
  // F and f add a vertex, G does not: two vertices are no polygon
  EXPECT_EQ(run.scene.segments.size(), 2U);
}

// Prusinkiewicz & Lindenmayer 1990, figure 5.5: a polygon may begin in a branch and end outside of it
TEST(Drawing, APolygonMayCrossBrackets) {
  TurtleRun run("[+F{.].F.}");
  run.draw();
  ASSERT_EQ(run.scene.polygons.size(), 1U);
  EXPECT_EQ(run.scene.polygons[0].vertices.size(), 4U);
}

TEST(Drawing, PolygonsNest) {
  TurtleRun run("{.f.{..f.}f.}");
  run.draw();
  ASSERT_EQ(run.scene.polygons.size(), 2U);
  EXPECT_EQ(run.scene.polygons[0].vertices.size(), 4U);
  EXPECT_EQ(run.scene.polygons[1].vertices.size(), 5U);
}

TEST(Drawing, CylindersInBracesTakeTheirPointsFromMovesAndDrawNoLines) {
  TurtleRun run("!(2){(3,6)FfG.(2)}(3)");
  run.draw();
  ASSERT_EQ(run.scene.cylinders.size(), 1U);
  const GeneralizedCylinder& cylinder = run.scene.cylinders[0];
  EXPECT_EQ(cylinder.curve, GeneralizedCylinder::Curve::BSpline);
  EXPECT_FALSE(cylinder.isClosed);
  ASSERT_EQ(cylinder.points.size(), 4U);
  EXPECT_EQ(cylinder.points[1].stripCount, 6);
  EXPECT_EQ(cylinder.points[3].stripCount, 2);
  EXPECT_EQ(cylinder.points[3].width, 2.0);
  EXPECT_TRUE(run.scene.segments.empty());
}

TEST(Drawing, AxisCylindersTakeExplicitPointsAndBranchesDrawOnTheirOwn) {
  TurtleRun run("@#(2)@!(5)@Gs F[+F]F@Gc(7)F@Gt(0.5,0.7)@Ge F");
  run.draw();
  ASSERT_EQ(run.scene.cylinders.size(), 1U);
  const GeneralizedCylinder& cylinder = run.scene.cylinders[0];
  ASSERT_EQ(cylinder.points.size(), 3U);
  EXPECT_EQ(cylinder.points[0].contour, 2);
  EXPECT_EQ(cylinder.points[0].sideCount, 5);
  EXPECT_EQ(cylinder.points[1].stripCount, 7);
  EXPECT_EQ(cylinder.points[2].stripCount, 4);
  EXPECT_EQ(cylinder.points[2].startTangent, 0.5);
  EXPECT_EQ(cylinder.points[2].endTangent, 0.7);
  // the branch's line and the one after the cylinder
  EXPECT_EQ(run.scene.segments.size(), 2U);
}

TEST(Drawing, OneParameterOfGrIsAFlagAndMoreAreTangents) {
  const auto lastPoint = [](const std::string& text) {
    TurtleRun run("@Gs" + text + "f(2)@Ge(2)");
    run.draw();
    return run.scene.cylinders.at(0).points.back();
  };
  EXPECT_FALSE(lastPoint("").hasSmoothRadius);
  EXPECT_FALSE(lastPoint("@Gr(90,1)@Gr(0)").hasSmoothRadius);
  const CylinderPoint level = lastPoint("@Gr(90,1)@Gr(1)");
  EXPECT_TRUE(level.hasSmoothRadius);
  EXPECT_EQ(level.startRadiusTangent, 0.0);
  const CylinderPoint both = lastPoint("@Gr(90,2)");
  EXPECT_TRUE(both.hasSmoothRadius);
  EXPECT_DOUBLE_EQ(both.startRadiusTangent, 2.0);
  EXPECT_DOUBLE_EQ(both.endRadiusTangent, 2.0);
  const CylinderPoint different = lastPoint("@Gr(90,2,-90,3)");
  EXPECT_DOUBLE_EQ(different.startRadiusTangent, 2.0);
  EXPECT_DOUBLE_EQ(different.endRadiusTangent, -3.0);
}

TEST(Drawing, ACylinderOfOnePointIsDropped) {
  TurtleRun run("@Gs F");
  run.draw();
  EXPECT_TRUE(run.scene.cylinders.empty());
}

TEST(Drawing, BallsHaveTheirDiameterOrTheLineWidth) {
  TurtleRun run("!(0.5)@D(2)@O(3)@o@c(1)@bo(2)@bc(2)@O(0)");
  run.draw();
  ASSERT_EQ(run.scene.balls.size(), 5U);
  EXPECT_EQ(run.scene.balls[0].kind, Ball::Kind::Sphere);
  EXPECT_EQ(run.scene.balls[0].diameter, 6.0);
  EXPECT_EQ(run.scene.balls[1].kind, Ball::Kind::ScreenDisc);
  EXPECT_EQ(run.scene.balls[1].diameter, 0.5);
  EXPECT_EQ(run.scene.balls[2].kind, Ball::Kind::Disc);
  EXPECT_EQ(run.scene.balls[3].kind, Ball::Kind::ScreenDisc);
  EXPECT_EQ(run.scene.balls[4].kind, Ball::Kind::Disc);
}

TEST(Drawing, PatchesTakeTheirPointsFromTheTurtle) {
  TurtleRun run("@PS(1)@PC(1,1,1)f@PC(1,4,4)@PD(1,3,2)@PD(9,1,1)");
  run.draw();
  ASSERT_EQ(run.scene.patches.size(), 1U);
  expectVector(run.scene.patches[0].points[15], 0, 1, 0);
  EXPECT_EQ(run.scene.patches[0].subdivisionS, 3);
  TurtleRun zero("@PS(1)f@PC(1,0,0)f@PC(1,3,3)@PD(1)");
  zero.draw();
  ASSERT_EQ(zero.scene.patches.size(), 1U);
  expectVector(zero.scene.patches[0].points[0], 0, 1, 0);
  expectVector(zero.scene.patches[0].points[15], 0, 2, 0);
}

TEST(Drawing, LabelsAreFormattedByTheModelsText) {
  TurtleRun run("F@L(0,3,0.25)");
  run.program.strings.push_back("n=%d x=%.1f %%");
  run.draw();
  ASSERT_EQ(run.scene.labels.size(), 1U);
  EXPECT_EQ(run.scene.labels[0].text, "n=3 x=0.2 %");
}

TEST(Drawing, LabelsKnowWhereTheyStand) {
  TurtleRun run("F[FFF@L(0,3)]");
  run.program.strings.push_back("%d");
  run.draw();
  ASSERT_EQ(run.scene.labels.size(), 1U);
  EXPECT_EQ(run.scene.labels[0].module, 5U);
  EXPECT_EQ(run.scene.labels[0].branchOrder, 1U);
  EXPECT_EQ(run.scene.labels[0].parent, 3U);
}

TEST(Drawing, LabelFormatsAreHarmless) {
  const std::array values{1.0, 2.0};
  EXPECT_EQ(formatLabel("%s%n %d|", values), " |");
  EXPECT_EQ(formatLabel("%99999999d", values), "%99999999d");
  EXPECT_EQ(formatLabel("%g %g %g|", values), "1 2 |");
  EXPECT_EQ(formatLabel("%", values), "%");
}

TEST(Drawing, WithoutASceneNothingIsKept) {
  TurtleRun run("F{.f.f.}@O");
  run.pass();
  EXPECT_TRUE(run.scene.empty());
}

TEST(Scene, ClearsEverything) {
  TurtleRun run("F{.f+f+f.}@O(1)");
  run.draw();
  EXPECT_FALSE(run.scene.empty());
  run.scene.clear();
  EXPECT_TRUE(run.scene.empty());
}

}  // namespace
}  // namespace espalier::turtle::drawing_test

#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "engine/files/curves/curve_file.h"
#include "engine/files/view_settings.h"

namespace espalier::files::parametric_curve_test {
namespace {

using core::Vec3;
using Kind = ParametricCurve::Kind;

const std::vector<Vec3> kRecorded = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0},
                                     {1, 1, 0}, {0, 2, 0}, {0, 2, 0}, {0, 2, 0}};

// recorded from the reference program
TEST(ParametricCurve, BSplineHasTheRecordedMiddleAndLength) {
  const ParametricCurve curve(Kind::BSpline, kRecorded, 100);
  EXPECT_NEAR(curve.point(0.5).x, 0.916157, 5e-7);
  EXPECT_NEAR(curve.point(0.5).y, 0.791969, 5e-7);
  EXPECT_NEAR(curve.arcLength(), 3.0627, 5e-5);
}

TEST(ParametricCurve, ClampsItsParameter) {
  const ParametricCurve curve(Kind::BSpline, kRecorded, 100);
  EXPECT_EQ(curve.point(-1.0), curve.point(0.0));
  EXPECT_EQ(curve.point(7.0), curve.point(1.0));
}

// equal steps of t cover equal lengths: a straight line with unevenly spaced control points
TEST(ParametricCurve, ParameterIsArcLength) {
  const ParametricCurve line(Kind::BSplineEndPoint, {{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {1, 0, 0}, {4, 0, 0}}, 1000);
  EXPECT_NEAR(line.arcLength(), 4.0, 1e-4);
  for (double t = 0.0; t <= 1.0; t += 0.125) {
    EXPECT_NEAR(line.point(t).x, 4.0 * t, 1e-4) << t;
  }
}

// de Casteljau at 1/2 of (0,0) (0,1) (1,1) (1,0): ((0 + 3·0 + 3·1 + 1)/8, (0 + 3·1 + 3·1 + 0)/8) = (1/2, 3/4)
TEST(ParametricCurve, BezierSegmentsShareTheirEnds) {
  const ParametricCurve one(Kind::Bezier, {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}, 101);
  EXPECT_NEAR(one.point(0.5).x, 0.5, 1e-5);
  EXPECT_NEAR(one.point(0.5).y, 0.75, 1e-5);
  const ParametricCurve two(Kind::Bezier,
                            {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}, {1, -1, 0}, {2, -1, 0}, {2, 0, 0}}, 201);
  EXPECT_NEAR(two.point(0.5).x, 1.0, 1e-4);
  EXPECT_NEAR(two.point(1.0).x, 2.0, 1e-4);
}

// the uniform B-spline starts in (P0 + 4 P1 + P2)/6; with the reflected point 2 P0 - P1 before, that is P0
TEST(ParametricCurve, PhantomPointsReachTheEnds) {
  const ParametricCurve curve(Kind::BSplinePhantom, {{0, 0, 0}, {1, 2, 0}, {3, 2, 0}, {4, 0, 0}}, 100);
  EXPECT_NEAR(core::length(curve.point(0.0)), 0.0, 1e-12);
  EXPECT_NEAR(core::length(curve.point(1.0) - Vec3{4, 0, 0}), 0.0, 1e-4);
}

TEST(ParametricCurve, ClosedCurveReturnsToItsStart) {
  const ParametricCurve curve(Kind::BSplineClosed, {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, 200);
  EXPECT_NEAR(core::length(curve.point(1.0) - curve.point(0.0)), 0.0, 1e-4);
}

TEST(ParametricCurve, BezierSurfaceIsTheEdgeWhereTheSecondParameterIsZero) {
  std::vector<Vec3> points(16, Vec3{9, 9, 9});
  points[0] = {0, 0, 0};
  points[4] = {1, 0, 0};
  points[8] = {2, 0, 0};
  points[12] = {3, 0, 0};
  const ParametricCurve curve(Kind::BezierSurface, points, 100);
  EXPECT_NEAR(curve.point(0.5).x, 1.5, 1e-4);
  EXPECT_NEAR(curve.point(0.5).y, 0.0, 1e-12);
}

TEST(ParametricCurve, CurveWithoutLengthStaysInItsPoint) {
  const ParametricCurve curve(Kind::BSpline, std::vector<Vec3>(4, Vec3{1, 2, 3}), 100);
  EXPECT_NEAR(core::length(curve.point(0.5) - Vec3{1, 2, 3}), 0.0, 1e-12);
  EXPECT_NEAR(curve.arcLength(), 0.0, 1e-12);
}

struct Read {
  ParametricCurve curve;
  core::DiagnosticList diagnostics;
};

Read read(const std::string& text) {
  core::DiagnosticList diagnostics;
  const DataFile file("c.con", text, diagnostics);
  ParametricCurve curve = readCurveFile(file, 100);
  return {std::move(curve), diagnostics};
}

std::string firstMessage(const core::DiagnosticList& diagnostics) {
  if (diagnostics.entries().empty()) {
    return "";
  }
  const core::Diagnostic& first = diagnostics.entries().front();
  return std::to_string(first.location.line) + ":" + std::to_string(first.location.column) + " " + first.message;
}

TEST(CurveFile, ReadsMultiplicitiesInTheFourthDimension) {
  const Read result = read(
      "version: 1\n// a comment\ncontact: 0 0 0\nunknown word: 3\npoints: 4\nrange: 0 1\ndimension: 4\ntype: bspline\n"
      "0 0 0 3\n1 0 0 1\n1 1 0 1\n0 2 0 3");
  EXPECT_TRUE(result.diagnostics.entries().empty());
  EXPECT_NEAR(result.curve.point(0.5).x, 0.916157, 5e-7);
  EXPECT_NEAR(result.curve.arcLength(), 3.0627, 5e-5);
}

TEST(CurveFile, DimensionIsTwoByDefault) {
  const Read result = read("points: 4\n0 0\n1 0\n2 0\n3 0\n");
  EXPECT_TRUE(result.diagnostics.entries().empty());
  // the plain uniform B-spline runs from P1 to P2 of equally spaced points
  EXPECT_NEAR(result.curve.point(0.0).x, 1.0, 1e-5);
  EXPECT_NEAR(result.curve.arcLength(), 1.0, 1e-5);
}

TEST(CurveFile, ReportsAPointWithTooFewNumbersAndIsTheOriginThen) {
  const Read result = read("points: 4\ndim: 3\n0 0 0\n1 0\n2 0 0\n3 0 0\n");
  EXPECT_EQ(firstMessage(result.diagnostics), "4:4 expected 3 numbers of a point while reading a curve, found the end");
  EXPECT_EQ(result.curve.point(0.5), (Vec3{0, 0, 0}));
  EXPECT_EQ(result.curve.arcLength(), 0.0);
}

TEST(CurveFile, ReportsMissingParts) {
  EXPECT_EQ(firstMessage(read("type: bspline\n").diagnostics),
            "2:1 expected 'points:' while reading a curve, found the end");
  EXPECT_EQ(firstMessage(read("points: 5\n0 0\n1 1\n2 2\n3 3\n").diagnostics),
            "6:1 expected 5 points while reading a curve, found the end");
  EXPECT_EQ(firstMessage(read("points: 3\n0 0\n1 1\n2 2\n").diagnostics),
            "1:1 a curve of this type needs at least 4 points, this one has 3");
  EXPECT_EQ(firstMessage(read("points: 4\ntype: bezier-surface\n0 0\n1 1\n2 2\n3 3\n").diagnostics),
            "1:1 a curve of this type needs at least 16 points, this one has 4");
  EXPECT_EQ(firstMessage(read("dimension: 7\n").diagnostics), "1:1 the dimension of a curve is 2, 3 or 4");
  EXPECT_EQ(firstMessage(read("0 0\n").diagnostics),
            "1:1 expected a keyword or 'points:' before the first point while reading a curve, found '0'");
}

TEST(CurveFile, LargeCountsAskForNoMemoryBeforeTheDataIsSeen) {
  EXPECT_EQ(firstMessage(read("points: 1000000000\n0 0\n").diagnostics),
            "3:1 expected 1000000000 points while reading a curve, found the end");
  EXPECT_EQ(firstMessage(read("points: 1\ndim: 4\n0 0 0 1e300\n").diagnostics),
            "3:1 a curve has at most 100000 points");
}

}  // namespace
}  // namespace espalier::files::parametric_curve_test

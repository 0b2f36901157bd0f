#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/files/view_settings.h"

namespace espalier::files::spline_function_test {
namespace {

using Points = std::vector<std::array<double, 2>>;

// figures recorded from the reference program (conformance cases 042 and 043); their parameters are printed with %g
constexpr double kPrinted = 1e-5;

TEST(SplineFunction, TabulatesTheRecordedRamp) {
  const SplineFunction ramp("ramp", Points{{0, 0}, {0.25, 0.5}, {0.75, 0.5}, {1, 2}}, 100);
  EXPECT_NEAR(ramp.value(0.0), 0.00146342, kPrinted);
  EXPECT_NEAR(ramp.value(0.1), 0.16175, kPrinted);
  EXPECT_NEAR(ramp.value(0.25), 0.338344, kPrinted);
  EXPECT_NEAR(ramp.value(0.7), 0.956801, kPrinted);
  EXPECT_NEAR(ramp.value(1.0), 1.99561, kPrinted);
}

TEST(SplineFunction, TabulatesTheRecordedBump) {
  const SplineFunction bump("bump", Points{{0, -1}, {0.2, 0.3}, {0.5, 4}, {0.8, 0.3}, {1, -1}}, 50);
  EXPECT_NEAR(bump.value(0.0), -0.99619, kPrinted);
  EXPECT_NEAR(bump.value(0.5), 2.14698, kPrinted);
  EXPECT_NEAR(bump.value(0.95), -0.653062, kPrinted);
}

TEST(SplineFunction, ClampsItsArgument) {
  const SplineFunction ramp("ramp", Points{{0, 0}, {0.25, 0.5}, {0.75, 0.5}, {1, 2}}, 100);
  EXPECT_EQ(ramp.value(-1.0), ramp.value(0.0));
  EXPECT_EQ(ramp.value(2.0), ramp.value(1.0));
  EXPECT_EQ(ramp.value(std::numeric_limits<double>::quiet_NaN()), ramp.value(0.0));
}

// control points on the line y = 2x + 1 with x equal to the Greville abscissae 0, 1/3, 2/3, 1: the spline is that line
// and x(p) = p, so only the search's error of at most 0.001 in x, i.e. 0.002 in y, remains
TEST(SplineFunction, ExactValuesAreWithinTheSearchError) {
  const SplineFunction line("line", Points{{0, 1}, {1.0 / 3, 5.0 / 3}, {2.0 / 3, 7.0 / 3}, {1, 3}}, 2);
  for (double x = 0.0; x <= 1.0; x += 0.0625) {
    EXPECT_NEAR(line.value(x), 2 * x + 1, 0.002) << x;
  }
  // the search stops at the first parameter that is near enough, so the value at 0 is not exactly 1
  EXPECT_NE(line.value(0.0), 1.0);
}

TEST(SplineFunction, SearchEndsWhereTheCurveNeverReachesX) {
  const SplineFunction constant("zero", Points(4), 0);
  EXPECT_EQ(constant.value(1.0), 0.0);
}

TEST(SplineFunction, ExactValuesAreThoseOfTheBisectionThatFillsTables) {
  // a table of 4,097 values holds the bisected ones at multiples of 1/4096; the curves rise, stand still, jump, turn
  // back, and leave [0, 1] or do not fill it
  const std::vector<Points> curves{{{0, 0}, {0.25, 0.5}, {0.75, 0.5}, {1, 2}},
                                   {{0, 0}, {0, 1}, {0, 2}, {0.01, 3}, {0.99, 4}, {1, 5}, {1, 6}, {1, 7}},
                                   {{0, 0}, {0.5, 1}, {0.5, 2}, {0.5, 3}, {0.5, 4}, {1, 5}},
                                   {{0, 0}, {0.9, 1}, {0.1, 2}, {1, 3}},
                                   {{0.3, 0}, {0.4, 1}, {0.5, 2}, {0.6, 3}},
                                   {{-1, 0}, {0.2, 1}, {0.7, 2}, {3, 3}},
                                   {{1, 0}, {0.7, 1}, {0.3, 2}, {0, 3}},
                                   Points(5)};
  for (const Points& points : curves) {
    const SplineFunction exact("exact", points, 0);
    const SplineFunction table("table", points, 4097);
    for (int i = 0; i <= 4096; ++i) {
      const double x = i / 4096.0;
      ASSERT_EQ(exact.value(x), table.value(x)) << points[1][0] << " at " << x;
    }
  }
}

}  // namespace
}  // namespace espalier::files::spline_function_test

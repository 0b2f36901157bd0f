// The references of `espalier validate`: closed forms, tables of reference values, the verdict of a row.

#include "clients/espalier/validation/validation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "clients/espalier/validation/built_in_tables.h"
#include "clients/espalier/validation/closed_forms.h"
#include "clients/espalier/validation/discrete_ordinates.h"
#include "clients/espalier/validation/reference_table.h"

namespace espalier::validation::validation_test {
namespace {

using std::numbers::pi;

TEST(ClosedForms, LightOfAHorizontalLayerIsReflectedAbsorbedOrOnTheGround) {
  // leaves that throw back and let through half of the light, two layers of them: half of it comes back
  const LayerFluxes overBlack = horizontalLayer(2.0, 0.5, 0.5, 0.0);
  EXPECT_DOUBLE_EQ(overBlack.reflected, 0.5);
  EXPECT_DOUBLE_EQ(overBlack.down, 0.5);
  EXPECT_NEAR(overBlack.absorbed, 0.0, 1e-12);
  // nothing is absorbed by such leaves over a white ground
  const LayerFluxes overWhite = horizontalLayer(2.0, 0.5, 0.5, 1.0);
  EXPECT_DOUBLE_EQ(overWhite.reflected, 1.0);
  EXPECT_NEAR(overWhite.absorbed, 0.0, 1e-12);
  // black leaves: exp(-L) down to the ground, a third of it up again, and exp(-L) of that
  const LayerFluxes ofBlack = horizontalLayer(1.5, 0.0, 0.0, 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(ofBlack.down, std::exp(-1.5));
  EXPECT_DOUBLE_EQ(ofBlack.reflected, std::exp(-3.0) / 3.0);
  // a layer between two halves of itself, by the sum of all ways between them
  const LayerFluxes whole = horizontalLayer(2.0, 0.3, 0.2, 0.0);
  const LayerFluxes half = horizontalLayer(1.0, 0.3, 0.2, 0.0);
  const double ways = 1.0 - half.reflected * half.reflected;
  EXPECT_NEAR(whole.down, half.down * half.down / ways, 1e-12);
  EXPECT_NEAR(whole.reflected, half.reflected + half.down * half.down * half.reflected / ways, 1e-12);
}

TEST(LargestError, IsNoNumberWithoutOneOrWithOneThatIsNone) {
  LargestError none;
  EXPECT_FALSE((Row{"", none.value(), 1.0, ""}.isMet()));
  LargestError some;
  for (const double error : {0.5, 0.75, 0.25}) {
    some.add(error);
  }
  EXPECT_EQ(some.value(), 0.75);
  some.add(std::numeric_limits<double>::quiet_NaN());
  some.add(0.25);
  EXPECT_FALSE((Row{"", some.value(), 1.0, ""}.isMet()));
}

TEST(Validation, ComparesNothingWithoutTheTablesOfOthers) {
  for (const Case& one : forestCases()) {
    const CaseResult result = one.run([](const std::string&) { return std::optional<std::string>(); });
    EXPECT_TRUE(result.rows.empty()) << one.name;
    EXPECT_FALSE(result.missing.empty()) << one.name;
  }
}

TEST(BuiltInTables, HoldReferenceValuesAndNothingOfOtherAuthors) {
  const auto data = [](const std::string& name) { return builtInTable(name); };
  std::size_t bytes = 0;
  for (const std::string_view name : builtInTableNames()) {
    std::vector<std::string> missing;
    const auto table = ReferenceTable::read(data, std::string(name), missing);
    ASSERT_TRUE(table) << name;
    EXPECT_GT(table->rowCount(), 5U) << name;
    EXPECT_TRUE(builtInTable(name)->starts_with("# ")) << name << " does not say what it is and whose";
    EXPECT_EQ(sourceOfTable(name), "") << name;
    bytes += builtInTable(name)->size();
  }
  EXPECT_LT(bytes, 40'000U);
  for (const std::string name : {"m1_root_traits", "m32_roots", "c12_roots", "c12_sinks", "c12_transpiration"}) {
    EXPECT_FALSE(builtInTable(name + ".tsv")) << name;
    EXPECT_NE(sourceOfTable(name + ".tsv").find("doi 10."), std::string_view::npos) << name;
  }
  EXPECT_EQ(sourceOfTable("m32_roots.tsv or m32_roots.rsml"), sourceOfTable("m32_roots.tsv"));
}

TEST(DiscreteOrdinates, SphericalLeavesGiveTheirClosedFormsAndLoseNothing) {
  // black leaves: Beer's law with G = 1/2
  const LayerFluxes black = sphericalLayer(3.0, 0.0, 0.0, 0.0, 60.0);
  EXPECT_NEAR(black.down, std::exp(-3.0), 1e-12);
  EXPECT_NEAR(black.reflected, 0.0, 1e-12);
  // under a uniform sky 2 E3(L/2); by the midpoint rule
  double passed = 0.0;
  for (int i = 0; i < 20'000; ++i) {
    const double cosine = (i + 0.5) / 20'000;
    passed += 2.0 * cosine * std::exp(-1.0 / cosine) / 20'000;
  }
  EXPECT_NEAR(sphericalLayer(2.0, 0.0, 0.0, 0.0, std::nullopt).down, passed, 1e-4);
  // leaves and a ground that take nothing
  EXPECT_NEAR(sphericalLayer(2.0, 0.5, 0.5, 1.0, 30.0).reflected, 1.0, 1e-6);
  // the same equations by another program: reflected, absorbed, down at the ground
  const LayerFluxes green = sphericalLayer(1.0, 0.0735, 0.0566, 0.964, 27.4643);
  EXPECT_NEAR(green.reflected, 0.285551, 2e-6);
  EXPECT_NEAR(green.absorbed, 0.692908, 2e-6);
  EXPECT_NEAR(green.down, 0.598366, 2e-6);
}

// of leaves without a preferred side the mean projection over all directions is a half (Ross 1981)
TEST(ClosedForms, TheMeanOfAllProjectionsIsAHalf) {
  for (const char* leaves :
       {"horizontal", "vertical", "spherical", "planophile", "erectophile", "plagiophile", "extremophile", "uniform"}) {
    double sum = 0.0;
    constexpr int kSteps = 12;
    for (int i = 0; i < kSteps; ++i) {
      const double zenith = 0.5 * pi * (i + 0.5) / kSteps;
      sum += leafProjection(leaves, 1.0, zenith) * std::sin(zenith) * 0.5 * pi / kSteps;
    }
    EXPECT_NEAR(sum, 0.5, 0.002) << leaves;
  }
  for (const double ratio : {0.5, 1.0, 3.0}) {
    double sum = 0.0;
    constexpr int kSteps = 1000;
    for (int i = 0; i < kSteps; ++i) {
      const double zenith = 0.5 * pi * (i + 0.5) / kSteps;
      sum += leafProjection("ellipsoidal", ratio, zenith) * std::sin(zenith) * 0.5 * pi / kSteps;
    }
    EXPECT_NEAR(sum, 0.5, 1e-5) << ratio;
  }
  for (const char* light : {"uniform", "overcast", "zenith0", "zenith60"}) {
    EXPECT_NEAR(passedBlackLeaves("horizontal", 1.0, light, 1.5), std::exp(-1.5), 1e-6) << light;
  }
}

TEST(ClosedForms, ViewFactorsOfACubeSumToOne) {
  const double opposed = viewFactor("rectangles", 1, 1, 1);
  const double beside = viewFactor("corner", 1, 1, 1);
  EXPECT_NEAR(opposed + 4.0 * beside, 1.0, 1e-12);
  EXPECT_NEAR(opposed, 0.19982, 1e-5);
  // what one sees of the other by its area is the same from both sides
  EXPECT_NEAR(1.0 * viewFactor("corner", 1, 3, 2), 3.0 * viewFactor("corner", 3, 1, 2), 1e-12);
  EXPECT_NEAR(1.0 * viewFactor("discs", 1, 2, 1.5), 4.0 * viewFactor("discs", 2, 1, 1.5), 1e-12);
  // a disc close before a large one sees nothing else
  EXPECT_NEAR(viewFactor("discs", 1, 1000, 0.1), 1.0, 1e-6);
  // a sphere in the middle of a cube gives each of the 24 quarters of its faces the same
  EXPECT_NEAR(viewFactor("sphere", 1, 1, 1), 1.0 / 24.0, 1e-12);
  // and a wide plain below it half of all in four quarters
  EXPECT_NEAR(viewFactor("sphere", 1e6, 1e6, 1), 0.125, 1e-6);
}

TEST(ClosedForms, ALensIsTheSameFromBothSides) {
  EXPECT_NEAR(lensArea(2, 2, 1), 8.0 * std::acos(0.25) - 0.5 * std::sqrt(15.0), 1e-12);
  EXPECT_NEAR(lensArea(3, 2, 2.5), lensArea(2, 3, 2.5), 1e-12);
  // discs that touch from outside and from inside
  EXPECT_NEAR(lensArea(3, 2, 5), 0.0, 1e-6);
  EXPECT_NEAR(lensArea(3, 2, 1), 4.0 * pi, 1e-6);
}

TEST(ReferenceTable, ErrorsAreSharesOfTheMeanOfTheReference) {
  EXPECT_DOUBLE_EQ(normalisedError({2.0, 4.0}, {3.0, 4.0}), std::sqrt(0.5) / 3.0);
  EXPECT_DOUBLE_EQ(normalisedError({-2.0, -4.0}, {-3.0, -4.0}), std::sqrt(0.5) / 3.0);
}

TEST(ReferenceTable, BetweenPointsIsALineAndBeyondThemNothingChanges) {
  const std::vector<std::pair<double, double>> points{{1.0, 10.0}, {2.0, 20.0}, {4.0, 0.0}};
  EXPECT_EQ(interpolate(points, 0.0), 10.0);
  EXPECT_EQ(interpolate(points, 1.0), 10.0);
  EXPECT_EQ(interpolate(points, 1.5), 15.0);
  EXPECT_EQ(interpolate(points, 3.0), 10.0);
  EXPECT_EQ(interpolate(points, 4.0), 0.0);
  EXPECT_EQ(interpolate(points, 9.0), 0.0);
}

TEST(Row, WithoutAResultDoesNotMeetItsTolerance) {
  const auto isMet = [](double error, std::optional<double> tolerance) {
    return Row{.what = "", .error = error, .tolerance = tolerance, .published = ""}.isMet();
  };
  EXPECT_TRUE(isMet(0.1, 0.1));
  EXPECT_FALSE(isMet(0.11, 0.1));
  EXPECT_FALSE(isMet(std::numeric_limits<double>::quiet_NaN(), 0.1));
  EXPECT_TRUE(isMet(std::numeric_limits<double>::quiet_NaN(), std::nullopt)) << "a figure that is only reported";
}

}  // namespace
}  // namespace espalier::validation::validation_test

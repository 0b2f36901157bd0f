#include "clients/espalier/roots/shoot_traits.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "clients/espalier/validation/canopy.h"

namespace espalier::roots::shoot_traits_test {
namespace {

TEST(ShootTraits, MeasureLeavesOfKnownShape) {
  environment::Canopy canopy;
  canopy.rectangle({0, 2, 0}, {0, 0, 1}, {4, 0, 0});  // level, area 4
  canopy.rectangle({0, 1, 0}, {0, 0, 2}, {1, 1, 0});  // at 45 degrees, area 2 √2
  canopy.rectangle({1, 3, 3}, {1, 0, 0}, {0, 2, 0});  // upright, area 2
  const ShootTraits traits = shootTraitsOf(*canopy.geometry(), 1, 0.0);
  const double area = 6 + 2 * std::sqrt(2.0);
  EXPECT_EQ(traits.leafCount, 3U);
  EXPECT_DOUBLE_EQ(traits.leafArea, area);
  EXPECT_NEAR(traits.inclination, (45 * 2 * std::sqrt(2.0) + 90 * 2) / area, 1e-9);
  EXPECT_DOUBLE_EQ(traits.inclinations[0], 4 / area);
  EXPECT_DOUBLE_EQ(traits.inclinations[4], 2 * std::sqrt(2.0) / area);
  EXPECT_DOUBLE_EQ(traits.inclinations[8], 2 / area);
  EXPECT_EQ(traits.base, 0.0);
  EXPECT_EQ(traits.top, 4.0);
  EXPECT_EQ(traits.crownWidths[0], 4.0);
  EXPECT_EQ(traits.crownWidths[1], 3.0);
  // the hull of (0,0), (4,0), (4,1), (2,3), (1,3), (0,2), by the shoelace formula
  EXPECT_DOUBLE_EQ(traits.crownArea, 0.5 * (0 + 4 + (12 - 2) + (6 - 3) + (2 - 0) + 0));
  EXPECT_DOUBLE_EQ(traits.leafAreaIndex, area / traits.crownArea);
  EXPECT_DOUBLE_EQ(shootTraitsOf(*canopy.geometry(), 1, 12.0).leafAreaIndex, area / 12);
}

TEST(ShootTraits, BallsAndCylindersAreNoLeaves) {
  environment::Canopy canopy;
  canopy.rectangle({0, 2, 0}, {0, 0, 1}, {4, 0, 0});
  canopy.rectangle({0, 9, 0}, {0, 0, 5}, {5, 0, 0});
  turtle::Geometry geometry = *canopy.geometry();
  for (const turtle::GeometryKind kind : {turtle::GeometryKind::Ball, turtle::GeometryKind::Cylinder}) {
    geometry.kind[1] = kind;
    const ShootTraits traits = shootTraitsOf(geometry, 1, 0.0);
    EXPECT_EQ(traits.leafCount, 1U);
    EXPECT_DOUBLE_EQ(traits.leafArea, 4.0);
    EXPECT_EQ(traits.top, 0.0) << "above the lowest point of all, which is the leaf";
    EXPECT_DOUBLE_EQ(traits.crownArea, 4.0);
  }
}

TEST(ShootTraits, OfRandomLeavesFollowTheSphericalDistribution) {
  // of normals without a preferred direction the part with an angle up to θ is 1 − cos θ, and the mean is 1 rad
  environment::Canopy canopy;
  canopy.layer(10, 3, 2, 40'000, false);
  const ShootTraits traits = shootTraitsOf(*canopy.geometry(), 1, 100.0);
  EXPECT_NEAR(traits.leafAreaIndex, 2, 1e-9);
  EXPECT_NEAR(traits.inclination, 180 / std::numbers::pi, 0.5);
  for (std::size_t group = 0; group < ShootTraits::kClasses; ++group) {
    const double from = std::cos(static_cast<double>(group) * std::numbers::pi / 18);
    const double to = std::cos(static_cast<double>(group + 1) * std::numbers::pi / 18);
    EXPECT_NEAR(traits.inclinations[group], from - to, 0.01) << group;
  }
}

TEST(ShootTraits, AnotherAxisIsUp) {
  environment::Canopy canopy;
  canopy.rectangle({0, 2, 0}, {0, 0, 1}, {4, 0, 0});
  const ShootTraits traits = shootTraitsOf(*canopy.geometry(), 2, 0.0);
  EXPECT_DOUBLE_EQ(traits.inclination, 90.0);
  EXPECT_EQ(traits.top, 1.0);
  EXPECT_EQ(traits.crownArea, 0.0);
  EXPECT_EQ(traits.leafAreaIndex, 0.0) << "of a crown without an area";
  EXPECT_NE(shootTraitRows(traits, 2, "cm").find("crown_width\tx\t4\tcm\ncrown_width\ty\t0\tcm\n"), std::string::npos);
}

TEST(ShootTraits, EveryRowHasItsUnit) {
  environment::Canopy canopy;
  canopy.rectangle({0, 2, 0}, {0, 0, 1}, {4, 0, 0});
  const auto unitOf = [&](const std::string& trait, const std::string& lengths) {
    const std::string rows = "\n" + shootTraitRows(shootTraitsOf(*canopy.geometry(), 2, 0.0), 2, lengths);
    const std::size_t row = rows.find("\n" + trait + "\t") + 1;
    const std::string line = rows.substr(row, rows.find('\n', row) - row);
    return line.substr(line.rfind('\t') + 1);
  };
  for (const auto& [trait, unit, withoutUnit] : {std::array{"leaf_number", "1", "1"},
                                                 {"leaf_area", "cm^2", "1"},
                                                 {"leaf_area_index", "1", "1"},
                                                 {"leaf_inclination", "degree", "degree"},
                                                 {"leaf_angle", "1", "1"},
                                                 {"crown_base", "cm", "1"},
                                                 {"crown_top", "cm", "1"},
                                                 {"crown_area", "cm^2", "1"}}) {
    EXPECT_EQ(unitOf(trait, "cm"), unit) << trait;
    EXPECT_EQ(unitOf(trait, "1"), withoutUnit) << trait;
  }
}

TEST(ShootTraits, PlantsWithoutLeavesHaveNone) {
  EXPECT_EQ(shootTraitRows(shootTraitsOf({}, 1, 0.0), 1, "m"), "");
}

}  // namespace
}  // namespace espalier::roots::shoot_traits_test

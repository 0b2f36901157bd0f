#include "environment/light/rays/ray_directions.h"

#include <gtest/gtest.h>

#include <cmath>

namespace espalier::environment::ray_directions_test {
namespace {

TEST(RayDirections, EveryLatticeIsSpreadEvenlyOverTheSphere) {
  // the mean of x² over the sphere is 1/3, that of x is 0
  const RayDirections directions(128);
  for (const RayDirections::Lattice& lattice : directions.lattices()) {
    core::Vec3 sum;
    core::Vec3 squares;
    for (std::size_t i = lattice.begin; i < lattice.begin + lattice.count; ++i) {
      const core::Vec3& d = directions.all()[i];
      EXPECT_NEAR(core::length(d), 1.0, 1e-12);
      sum = sum + d;
      squares = squares + core::Vec3{d.x * d.x, d.y * d.y, d.z * d.z};
    }
    const auto count = static_cast<double>(lattice.count);
    EXPECT_LT(core::length(sum) / count, 0.1);
    EXPECT_NEAR(squares.x / count, 1.0 / 3, 0.08);
    EXPECT_NEAR(squares.y / count, 1.0 / 3, 0.08);
    EXPECT_NEAR(squares.z / count, 1.0 / 3, 0.08);
  }
}

TEST(RayDirections, ThinnedLatticesHaveHalfAsManyDownToTheLeast) {
  const RayDirections directions(128);
  EXPECT_EQ(directions.lastThinning(), 3U);
  for (const unsigned thinning : {0U, 1U, 2U, 3U, 9U}) {
    EXPECT_EQ(directions.latticeOf(thinning, 5).count, 128U >> std::min(thinning, 3U));
  }
  EXPECT_EQ(directions.latticeOf(0, 0).begin, 0U);
  EXPECT_EQ(RayDirections(8).lastThinning(), 0U);
}

TEST(RayDirections, NeighbouringSeedsLookElsewhere) {
  const RayDirections directions(128);
  EXPECT_NE(directions.latticeOf(3, 20).begin, directions.latticeOf(3, 21).begin);
  EXPECT_EQ(directions.latticeOf(3, 20).begin, directions.latticeOf(3, 36).begin);
  // very fine ones need no turns
  EXPECT_EQ(RayDirections(4096).latticeOf(0, 20).begin, 0U);
}

}  // namespace
}  // namespace espalier::environment::ray_directions_test

#include "environment/competition/zone_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace espalier::environment::zone_grid_test {
namespace {

using Disc = ZoneGrid::Disc;

bool holds(const Disc& disc, double x, double z) {
  const double dx = disc.x - x;
  const double dz = disc.z - z;
  return dx * dx + dz * dz <= disc.radius * disc.radius;
}

// points everywhere, and on the borders of discs
void expectToFindAll(const std::vector<Disc>& discs, double extent) {
  const ZoneGrid grid(discs);
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (int round = 0; round < 2'000; ++round) {
    double x = share(engine) * extent;
    double z = share(engine) * extent;
    if (round % 2 == 0 && !discs.empty()) {
      const Disc& disc = discs[engine() % discs.size()];
      x = disc.x + (round % 4 == 0 ? disc.radius : 0.0);
      z = disc.z - (round % 4 == 0 ? 0.0 : disc.radius);
    }
    const auto near = grid.near(x, z);
    EXPECT_TRUE(std::is_sorted(near.begin(), near.end()));
    for (std::uint32_t i = 0; i < discs.size(); ++i) {
      if (holds(discs[i], x, z)) {
        EXPECT_TRUE(std::binary_search(near.begin(), near.end(), i)) << x << " " << z;
      }
    }
  }
}

TEST(ZoneGrid, ListsEveryDiscOverAPoint) {
  std::mt19937_64 engine(9);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (const std::size_t count : {0U, 1U, 7U, 300U}) {
    for (const double radius : {0.001, 0.3, 20.0}) {
      std::vector<Disc> discs;
      for (std::size_t i = 0; i < count; ++i) {
        discs.push_back({share(engine) * 10.0, share(engine) * 10.0, radius * (i % 9 == 0 ? 10.0 : 1.0)});
      }
      expectToFindAll(discs, 12.0);
    }
  }
}

TEST(ZoneGrid, TakesDiscsOfAnySize) {
  const double most = std::numeric_limits<double>::max();
  expectToFindAll({{0.0, 0.0, most}, {-most, most, 1.0}, {1.0, 1.0, 1e-300}}, 2.0);
  expectToFindAll({{5.0, 5.0, 1e-308}}, 6.0);
}

TEST(ZoneGrid, LooksAtFewDiscsWhereZonesAreSmall) {
  std::vector<Disc> discs;
  for (int i = 0; i < 10'000; ++i) {
    discs.push_back({i % 100 * 1.0, i / 100 * 1.0, 0.6});
  }
  const ZoneGrid grid(discs);
  EXPECT_LE(grid.near(50.3, 50.3).size(), 9U);
}

}  // namespace
}  // namespace espalier::environment::zone_grid_test

#include "engine/simulation/step/seed_bed.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace espalier::simulation::seed_bed_test {
namespace {

constexpr core::Vec3 kUp{0, 1, 0};

std::vector<Seed> seedsAt(const std::vector<core::Vec3>& positions) {
  std::vector<Seed> seeds;
  for (const core::Vec3& position : positions) {
    Seed seed;
    seed.mother = static_cast<std::uint32_t>(seeds.size());
    seed.position = position;
    seeds.push_back(seed);
  }
  return seeds;
}

std::vector<bool> outcomes(const std::vector<Seed>& seeds) {
  std::vector<bool> roots;
  for (const Seed& seed : seeds) {
    roots.push_back(seed.hasTakenRoot);
  }
  return roots;
}

TEST(SeedBed, SeedsFallToTheGround) {
  auto seeds = seedsAt({{1, 7, 2}, {3, -2, 4}});
  settleSeeds(seeds, {}, {.ground = 0.5}, kUp, 1, 0);
  EXPECT_EQ(seeds[0].position, (core::Vec3{1, 0.5, 2}));
  EXPECT_EQ(seeds[1].position, (core::Vec3{3, 0.5, 4}));
}

TEST(SeedBed, APlantKeepsItsNeighboursAway) {
  // the border of the spacing is free: a seed is lost when it is nearer than 2
  auto seeds = seedsAt({{1.9, 3, 0}, {2, 3, 0}, {-2.5, 0, 0}});
  settleSeeds(seeds, {{0, 0, 0}}, {.spacing = 2}, kUp, 1, 0);
  EXPECT_EQ(outcomes(seeds), (std::vector<bool>{false, true, true}));
}

TEST(SeedBed, OfSeedsThatAreTooNearOneTakesRoot) {
  auto seeds = seedsAt({{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}});
  settleSeeds(seeds, {}, {.spacing = 1}, kUp, 1, 0);
  EXPECT_EQ(std::count_if(seeds.begin(), seeds.end(), [](const Seed& seed) { return seed.hasTakenRoot; }), 1);
}

TEST(SeedBed, TheOrderOfTheSeedsDoesNotMatter) {
  std::vector<core::Vec3> places;
  for (int i = 0; i < 200; ++i) {
    places.push_back({std::fmod(i * 0.618, 5.0), 0, std::fmod(i * 0.414, 5.0)});
  }
  auto seeds = seedsAt(places);
  auto shuffled = seeds;
  std::reverse(shuffled.begin(), shuffled.end());
  std::swap(shuffled[3], shuffled[150]);
  const SeedRules rules{.maximumPlants = 60, .spacing = 0.3};
  settleSeeds(seeds, {{2, 0, 2}}, rules, kUp, 9, 4);
  settleSeeds(shuffled, {{2, 0, 2}}, rules, kUp, 9, 4);
  std::sort(shuffled.begin(), shuffled.end(), [](const Seed& a, const Seed& b) { return a.mother < b.mother; });
  EXPECT_EQ(outcomes(seeds), outcomes(shuffled));
  const auto count = std::count_if(seeds.begin(), seeds.end(), [](const Seed& seed) { return seed.hasTakenRoot; });
  EXPECT_GT(count, 20);
  EXPECT_LE(count, 59);  // 60 live at most, and one was there
}

TEST(SeedBed, WithoutRoomForAllNoNumberIsFavoured) {
  // half of 1000 seeds find room: with a fair draw the lower half gets 250, with a deviation of 11
  std::vector<core::Vec3> places;
  for (int i = 0; i < 1000; ++i) {
    places.push_back({static_cast<double>(i), 0, 0});
  }
  auto seeds = seedsAt(places);
  settleSeeds(seeds, {}, {.maximumPlants = 500}, kUp, 3, 8);
  const auto low = std::count_if(seeds.begin(), seeds.begin() + 500, [](const Seed& s) { return s.hasTakenRoot; });
  const auto all = std::count_if(seeds.begin(), seeds.end(), [](const Seed& s) { return s.hasTakenRoot; });
  EXPECT_EQ(all, 500);
  EXPECT_NEAR(static_cast<double>(low), 250.0, 55.0);
}

TEST(SeedBed, TheAreaDoesNotCountAlongTheWorldsUp) {
  auto seeds = seedsAt({{0, 40, 0}, {3.5, 0, 0}, {0, 0, -3.5}, {3, 0, 3}});
  SeedRules rules;
  rules.area = std::array{core::Vec3{-3, 0, -3}, core::Vec3{3, 0, 3}};
  settleSeeds(seeds, {}, rules, kUp, 1, 0);
  EXPECT_EQ(outcomes(seeds), (std::vector<bool>{true, false, false, true}));
}

}  // namespace
}  // namespace espalier::simulation::seed_bed_test

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "tests/environment/query_builder.h"

namespace espalier::environment::ecosystem_test {
namespace {

struct Plant {
  core::Vec3 position;
  double radius;
  double second;  // group or vigor
};

bool areOverlapping(const Plant& a, const Plant& b, bool isSpace) {
  const core::Vec3 d = a.position - b.position;
  const double squared = d.x * d.x + d.z * d.z + (isSpace ? d.y * d.y : 0.0);
  return squared <= (a.radius + b.radius) * (a.radius + b.radius);
}

std::vector<double> answersFor(const std::vector<Plant>& plants, const std::string& configuration) {
  const auto process = openProcess("ecosystem", configuration);
  QueryBuilder builder;
  for (const Plant& plant : plants) {
    builder.add(plant.position, {plant.radius, plant.second});
  }
  return firstValues(answersOf(*process, builder.batch()));
}

std::vector<double> bruteForceByRadius(const std::vector<Plant>& plants, bool isSpace) {
  std::vector<double> values;
  for (std::size_t i = 0; i < plants.size(); ++i) {
    bool isDominated = false;
    for (std::size_t j = 0; j < plants.size(); ++j) {
      isDominated =
          isDominated || (i != j && plants[i].second == plants[j].second && plants[j].radius >= plants[i].radius &&
                          areOverlapping(plants[i], plants[j], isSpace));
    }
    values.push_back(isDominated ? 0.0 : 1.0);
  }
  return values;
}

/// Domination with vigor, settled in the given order of plants.
std::vector<double> bruteForceByVigor(const std::vector<Plant>& plants, const std::vector<std::size_t>& order) {
  std::vector<double> values(plants.size(), 1.0);
  for (const std::size_t i : order) {
    for (std::size_t j = 0; j < plants.size(); ++j) {
      const bool isStronger = plants[j].second > plants[i].second ||
                              (plants[j].second == plants[i].second && plants[j].radius > plants[i].radius);
      if (isStronger && values[j] == 1.0 && areOverlapping(plants[i], plants[j], false)) {
        values[i] = 0.0;
      }
    }
  }
  return values;
}

std::vector<Plant> randomPlants(std::size_t count, double extent, std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(-extent, extent);
  std::uniform_int_distribution<int> few(0, 4);
  std::vector<Plant> plants;
  for (std::size_t i = 0; i < count; ++i) {
    const double radius = few(random) == 0 ? 3.0 : 0.25 * few(random);
    plants.push_back({{place(random), place(random), place(random)}, radius, static_cast<double>(few(random))});
  }
  return plants;
}

std::vector<std::size_t> stringOrder(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

TEST(Ecosystem, EqualsBruteForceOnRandomPlants) {
  std::mt19937_64 random(2);
  for (const double extent : {2.0, 10.0, 40.0}) {
    const auto plants = randomPlants(400, extent, random);
    EXPECT_EQ(answersFor(plants, ""), bruteForceByRadius(plants, false));
    EXPECT_EQ(answersFor(plants, R"({"threeDimensional":true})"), bruteForceByRadius(plants, true));
    auto strongestFirst = stringOrder(plants.size());
    std::stable_sort(strongestFirst.begin(), strongestFirst.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(plants[a].second, plants[a].radius) > std::pair(plants[b].second, plants[b].radius);
    });
    EXPECT_EQ(answersFor(plants, R"({"vigor":true})"), bruteForceByVigor(plants, strongestFirst));
    EXPECT_EQ(answersFor(plants, R"({"vigor":true,"order":"published"})"),
              bruteForceByVigor(plants, stringOrder(plants.size())));
  }
}

TEST(Ecosystem, TheDefaultDoesNotDependOnTheOrderOfQueries) {
  std::mt19937_64 random(4);
  const auto plants = randomPlants(300, 8.0, random);
  for (const std::string configuration : {"{}", R"({"vigor":true})"}) {
    const auto expected = answersFor(plants, configuration);
    auto order = stringOrder(plants.size());
    for (int round = 0; round < 3; ++round) {
      std::shuffle(order.begin(), order.end(), random);
      std::vector<Plant> shuffled;
      for (const std::size_t i : order) {
        shuffled.push_back(plants[i]);
      }
      const auto values = answersFor(shuffled, configuration);
      for (std::size_t k = 0; k < order.size(); ++k) {
        EXPECT_EQ(values[k], expected[order[k]]);
      }
    }
  }
}

TEST(Ecosystem, DominatedPlantsStopDominating) {
  // a beats b, so b, though stronger than c, no longer stands in its way (conformance case 185)
  const std::vector<Plant> plants{{{0, 0, 0}, 1, 3}, {{1.5, 0, 0}, 1, 2}, {{3.2, 0, 0}, 1, 1}};
  EXPECT_EQ(answersFor(plants, R"({"vigor":true})"), (std::vector<double>{1, 0, 1}));
  // in string order c is settled before b is dominated
  const std::vector<Plant> reversed{plants[2], plants[1], plants[0]};
  EXPECT_EQ(answersFor(reversed, R"({"vigor":true,"order":"published"})"), (std::vector<double>{0, 0, 1}));
  EXPECT_EQ(answersFor(reversed, R"({"vigor":true})"), (std::vector<double>{1, 0, 1}));
}

TEST(Ecosystem, EqualRadiiBlockEachOtherButEqualVigorAndRadiusDoNot) {
  const std::vector<Plant> plants{{{0, 0, 0}, 1, 1}, {{2, 9, 0}, 1, 1}};
  EXPECT_EQ(answersFor(plants, ""), (std::vector<double>{0, 0}));
  EXPECT_EQ(answersFor(plants, R"({"threeDimensional":true})"), (std::vector<double>{1, 1}));
  EXPECT_EQ(answersFor(plants, R"({"vigor":true})"), (std::vector<double>{1, 1}));
}

TEST(Ecosystem, GroupsDoNotCompeteWithEachOther) {
  EXPECT_EQ(answersFor({{{0, 0, 0}, 1, 1}, {{1, 0, 0}, 5, 2}, {{1, 0, 0}, 2, 1}}, ""), (std::vector<double>{0, 1, 1}));
}

}  // namespace
}  // namespace espalier::environment::ecosystem_test

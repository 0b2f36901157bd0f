#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "tests/environment/query_builder.h"

namespace espalier::environment::honda_test {
namespace {

struct Tip {
  core::Vec3 position;
  double vigor;
  double group;
};

/// The definition, pair by pair: blocked when another of the same group with at least the vigor is within the radius.
std::vector<double> bruteForce(const std::vector<Tip>& tips, double radius, const core::Vec3& mask) {
  std::vector<double> values;
  for (std::size_t i = 0; i < tips.size(); ++i) {
    bool isBlocked = false;
    for (std::size_t j = 0; j < tips.size() && !isBlocked; ++j) {
      const core::Vec3 d = tips[j].position - tips[i].position;
      const double squared = d.x * d.x * mask.x + d.y * d.y * mask.y + d.z * d.z * mask.z;
      isBlocked =
          i != j && tips[i].group == tips[j].group && tips[i].vigor <= tips[j].vigor && squared <= radius * radius;
    }
    values.push_back(isBlocked ? 0.0 : 1.0);
  }
  return values;
}

std::vector<double> processAnswers(const std::vector<Tip>& tips, const std::string& configuration) {
  const auto process = openProcess("honda", configuration);
  QueryBuilder builder;
  for (const Tip& tip : tips) {
    builder.add(tip.position, {tip.vigor, tip.group});
  }
  return firstValues(answersOf(*process, builder.batch()));
}

/// Points on a coarse lattice part of the time, so that ties of distance and of vigor happen.
std::vector<Tip> randomTips(std::size_t count, double extent, std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(-extent, extent);
  std::uniform_int_distribution<int> few(0, 3);
  std::vector<Tip> tips;
  for (std::size_t i = 0; i < count; ++i) {
    core::Vec3 p{place(random), place(random), place(random)};
    if (few(random) == 0) {
      p = {std::round(p.x * 2) / 2, std::round(p.y * 2) / 2, std::round(p.z * 2) / 2};
    }
    tips.push_back({p, static_cast<double>(few(random)), static_cast<double>(few(random) / 2)});
  }
  return tips;
}

TEST(Honda, EqualsBruteForceOnRandomTipsInEveryPlaneAndInSpace) {
  std::mt19937_64 random(7);
  for (const double extent : {0.3, 3.0, 20.0}) {
    for (const double radius : {0.0, 0.1, 0.5, 1.0, 7.0}) {
      const auto tips = randomTips(300, extent, random);
      const std::string text = R"({"radius":)" + std::to_string(radius);
      EXPECT_EQ(processAnswers(tips, text + "}"), bruteForce(tips, radius, {1, 0, 1}));
      EXPECT_EQ(processAnswers(tips, text + R"(,"plane":"xy"})"), bruteForce(tips, radius, {1, 1, 0}));
      EXPECT_EQ(processAnswers(tips, text + R"(,"plane":"yz"})"), bruteForce(tips, radius, {0, 1, 1}));
      EXPECT_EQ(processAnswers(tips, text + R"(,"threeDimensional":true})"), bruteForce(tips, radius, {1, 1, 1}));
    }
  }
}

TEST(Honda, DoesNotDependOnTheOrderOfQueries) {
  std::mt19937_64 random(11);
  const auto tips = randomTips(500, 4.0, random);
  const auto expected = processAnswers(tips, R"({"radius":0.7,"threeDimensional":true})");
  std::vector<std::size_t> order(tips.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (int round = 0; round < 5; ++round) {
    std::shuffle(order.begin(), order.end(), random);
    std::vector<Tip> shuffled;
    for (const std::size_t i : order) {
      shuffled.push_back(tips[i]);
    }
    const auto values = processAnswers(shuffled, R"({"radius":0.7,"threeDimensional":true})");
    for (std::size_t k = 0; k < order.size(); ++k) {
      EXPECT_EQ(values[k], expected[order[k]]);
    }
  }
}

TEST(Honda, TheBorderOfTheRadiusIsInside) {
  // distance 5 by the 3-4-5 triangle, exactly representable
  const std::vector<Tip> tips{{{0, 0, 0}, 1, 0}, {{3, 0, 4}, 2, 0}};
  EXPECT_EQ(processAnswers(tips, R"({"radius":5})"), (std::vector<double>{0, 1}));
  EXPECT_EQ(processAnswers(tips, R"({"radius":4.999999})"), (std::vector<double>{1, 1}));
}

TEST(Honda, EqualsBlockEachOtherAndTheStrongerWins) {
  EXPECT_EQ(processAnswers({{{0, 0, 0}, 1, 0}, {{0.1, 0, 0}, 1, 0}}, R"({"radius":1})"), (std::vector<double>{0, 0}));
  EXPECT_EQ(processAnswers({{{0, 0, 0}, 1, 0}, {{0.1, 0, 0}, 2, 0}}, R"({"radius":1})"), (std::vector<double>{0, 1}));
  EXPECT_EQ(processAnswers({{{0, 0, 0}, 1, 3}, {{0.1, 0, 0}, 1, 4}}, R"({"radius":1})"), (std::vector<double>{1, 1}));
}

TEST(Honda, RadiusZeroBlocksTheSamePointOnly) {
  const std::vector<Tip> tips{{{1, 0, 0}, 1, 0}, {{1, 5, -0.0}, 1, 0}, {{1 + 1e-12, 0, 0}, 1, 0}};
  EXPECT_EQ(processAnswers(tips, "{}"), (std::vector<double>{0, 0, 1}));
  EXPECT_EQ(processAnswers(tips, R"({"threeDimensional":true})"), (std::vector<double>{1, 1, 1}));
}

TEST(Honda, OnlyTheFirstParameterIsAnsweredAndMissingOnesAreZero) {
  const auto process = openProcess("honda", R"({"radius":1})");
  QueryBuilder builder;
  // without a group it is group 0, without a vigor vigor 0; a module without parameters blocks but gets no answer
  builder.add({0, 0, 0}, {2, 1, 30}).add({0, 0, 0}, {3}).add({9, 0, 0}, {}).add({9, 0, 0}, {0});
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  ASSERT_FALSE(process->step(builder.batch(), replies));
  const ReplyTable table = tableOf(builder.batch(), replies);
  EXPECT_EQ(table[0], (std::vector<std::optional<double>>{1.0, std::nullopt, std::nullopt}));
  EXPECT_EQ(table[1][0], 1.0);
  EXPECT_EQ(table[3][0], 0.0);
  EXPECT_EQ(replies.answeredCount, 3U);
  EXPECT_EQ(replies.surplusCount, 0U);
}

TEST(Honda, FarCoordinatesAreNoProblem) {
  const std::vector<Tip> tips{
      {{1e300, 0, -1e300}, 1, 0}, {{1e300, 0, -1e300}, 1, 0}, {{-1e18, 0, 3}, 1, 0}, {{-1e18, 0, 3.5}, 2, 0}};
  EXPECT_EQ(processAnswers(tips, R"({"radius":0.6})"), bruteForce(tips, 0.6, {1, 0, 1}));
}

TEST(Honda, ACrowdOfOneVigorCostsNoMoreThanSorting) {
  // all tips within one radius: pair by pair this would be 4e10 comparisons, minutes; sorted it is well under a second
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(0.0, 1.0);
  std::vector<Tip> tips;
  for (int i = 0; i < 200'000; ++i) {
    tips.push_back({{place(random), place(random), place(random)}, static_cast<double>(i % 7), 0});
  }
  const auto values = processAnswers(tips, R"({"radius":2,"threeDimensional":true})");
  EXPECT_EQ(std::count(values.begin(), values.end(), 1.0), 0);
}

}  // namespace
}  // namespace espalier::environment::honda_test

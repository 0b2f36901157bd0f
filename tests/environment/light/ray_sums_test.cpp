#include "environment/light/ray_sums.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "tests/environment/query_builder.h"

namespace espalier::environment::ray_sums_test {
namespace {

struct Leaf {
  core::Vec3 place;
  double size = 0.0;
};

Leaf randomLeaf(std::mt19937_64& random) {
  // whole places: some leaves are the same
  std::uniform_int_distribution<int> place(0, 9);
  std::uniform_int_distribution<int> size(1, 3);
  return {{1.0 * place(random), 1.0 * place(random), 1.0 * place(random)}, 0.3 * size(random)};
}

struct Candidate {
  const char* name;
  const char* configuration;
};

class KeptRays : public testing::TestWithParam<Candidate> {};

// every step is answered by a process that saw the steps before and by a new one
TEST_P(KeptRays, AnswersAreThoseOfANewBeginningWhateverCameAndWent) {
  std::mt19937_64 random(21);
  std::vector<Leaf> leaves;
  for (int i = 0; i < 400; ++i) {
    leaves.push_back(randomLeaf(random));
  }
  const auto kept = openProcess(GetParam().name, GetParam().configuration);
  for (int step = 0; step < 30; ++step) {
    // a few come and go, in some steps none, in some nearly all
    const std::size_t count = step % 10 == 9 ? 300 : static_cast<std::size_t>(step % 5) * 4;
    std::shuffle(leaves.begin(), leaves.end(), random);
    for (std::size_t k = 0; k < count; ++k) {
      leaves[k] = randomLeaf(random);
    }
    for (std::size_t k = 0; k < static_cast<std::size_t>(step % 3); ++k) {
      leaves.push_back(randomLeaf(random));
    }
    if (step == 20) {
      leaves.clear();
    }
    QueryBuilder builder;
    for (const Leaf& leaf : leaves) {
      const bool isTakenaka = std::string(GetParam().name) == "takenaka";
      builder.add(leaf.place, isTakenaka ? std::vector{leaf.size, 0.0} : std::vector{leaf.size, 0.0, 0.0, 0.0});
    }
    const auto anew = openProcess(GetParam().name, GetParam().configuration);
    ASSERT_EQ(answersOf(*kept, builder.batch()), answersOf(*anew, builder.batch())) << "step " << step;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Processes, KeptRays,
    testing::Values(Candidate{"chiba", R"({"sampleCount":8})"},
                    Candidate{"chiba", R"({"sources":[[0,1,0,1],[0.3,1,0.2,1]],"beamRadius":0.5,"transmittance":0.9})"},
                    // dark after few spheres, after the first one, never
                    Candidate{"chiba", R"({"sources":[[0,1,0,1]],"transmittance":0.0001})"},
                    Candidate{"chiba", R"({"sources":[[0,1,0,1]],"transmittance":0})"},
                    Candidate{"chiba", R"({"sources":[[0,1,0,1]],"transmittance":1})"},
                    Candidate{"chiba", R"({"sources":[[0,1,0,1]],"estimateIntersectionArea":true})"},
                    Candidate{"takenaka", R"({"sources":[[0,100,0,1],[5,5,5,0.5]],"beamRadius":0.2})"},
                    Candidate{"takenaka", R"({"transmittance":0.0001,"parameterS":1})"},
                    Candidate{"takenaka", R"({"transmittance":0,"parameterS":1})"}),
    [](const auto& one) { return one.param.name + std::to_string(one.index); });

TEST(RaySums, ColumnsAndTheTreeGiveTheSameSums) {
  std::mt19937_64 random(22);
  std::uniform_real_distribution<double> place(0, 10);
  // spheres alike, and some so large among points that columns are given up
  for (const double large : {0.4, 30.0}) {
    std::vector<Sphere> spheres;
    for (int i = 0; i < 2000; ++i) {
      spheres.push_back({{place(random), place(random), place(random)}, i % 20 == 0 ? large : 0.05 * (i % 5)});
    }
    spheres.insert(spheres.end(), spheres.begin(), spheres.begin() + 50);  // some twice
    const std::array<core::Vec3, 3> directions{core::Vec3{0, 1, 0}, core::Vec3{0.6, 0, -0.8},
                                               core::Vec3{0.48, 0.6, 0.64}};
    const auto sumsOf = [&](bool areParallel, std::int64_t limit) {
      RaySums sums;
      std::vector<std::vector<std::int64_t>> found(2000);
      sums.update(distinctSpheres(spheres),
                  RaySums::Rays{3, limit,
                                [&](const Sphere& own, std::size_t k) {
                                  return Ray{own.centre, directions[k], HUGE_VAL};
                                },
                                [](const Sphere& own) { return 0.5 * own.radius; },
                                [](const Sphere& own, const Sphere& other, const Ray& ray) {
                                  const core::Vec3 between = other.centre - own.centre;
                                  const double ahead = core::dot(between, ray.direction);
                                  const double past = core::length(between - ray.direction * ahead);
                                  const double radius = other.radius + 0.5 * own.radius;
                                  return static_cast<std::int64_t>(
                                      ahead > 0.0 && past < radius ? 100.0 * (radius - past) : 0.0);
                                },
                                areParallel},
                  [&](std::uint32_t index, std::span<const std::int64_t> along) {
                    found[index].assign(along.begin(), along.end());
                  });
      return found;
    };
    for (const std::int64_t limit : {RaySums::kMostLimit, std::int64_t{60}, std::int64_t{0}}) {
      const auto byTree = sumsOf(false, limit);
      EXPECT_EQ(sumsOf(true, limit), byTree) << large << ' ' << limit;
      EXPECT_TRUE(std::ranges::any_of(byTree, [](const auto& along) {
        return along != std::vector<std::int64_t>{0, 0, 0};
      }));
    }
  }
}

TEST(RaySums, OnlyWhatChangedIsAskedForAgain) {
  // a row of 1000 spheres under one ray each; one more at the end of the row
  std::vector<Sphere> spheres;
  for (int i = 0; i < 1000; ++i) {
    spheres.push_back({{2.0 * i, 0, 0}, 0.5});
    spheres.push_back({{2.0 * i, 3, 0}, 0.5});
  }
  RaySums sums;
  std::size_t asked = 0;
  const auto update = [&] {
    asked = 0;
    std::vector<std::int64_t> found;
    sums.update(distinctSpheres(spheres),
                RaySums::Rays{1, RaySums::kMostLimit,
                              [](const Sphere& own, std::size_t) {
                                return Ray{own.centre, {0, 1, 0}, 1e9};
                              },
                              [](const Sphere&) { return 0.0; },
                              [&](const Sphere& own, const Sphere& other, const Ray&) {
                                ++asked;
                                return static_cast<std::int64_t>(other.centre.x == own.centre.x &&
                                                                 other.centre.y > own.centre.y);
                              }},
                [&](std::uint32_t, std::span<const std::int64_t> along) { found.push_back(along[0]); });
    return found;
  };
  const auto first = update();
  EXPECT_EQ(std::count(first.begin(), first.end(), 1), 1000);
  EXPECT_GE(asked, 1000U);
  EXPECT_EQ(update(), first);
  EXPECT_EQ(asked, 0U);
  spheres.push_back({{0, 6, 0}, 0.5});
  const auto second = update();
  // the two below it have one more, its own ray meets none; the rays of all others are not traced
  EXPECT_EQ(std::count(second.begin(), second.end(), 2), 1);
  EXPECT_EQ(std::count(second.begin(), second.end(), 1), 1000);
  EXPECT_LE(asked, 10U);
}

}  // namespace
}  // namespace espalier::environment::ray_sums_test

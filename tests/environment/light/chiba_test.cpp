#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

#include "environment/light/light_directions.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::chiba_test {
namespace {

constexpr const char* kZenith = R"({"transmittance":0.25,"sources":[[0,1,0,1]])";

std::string zenith(const std::string& more = "") {
  return kZenith + (more.empty() ? "" : "," + more) + "}";
}

TEST(Chiba, ASphereAboveTakesLightByItsChord) {
  // Light from straight above. A sphere of radius 1 whose middle is 0.6 aside of the ray has the chord 2·√(1−0.36)
  // = 1.6 of its diameter 2: t^0.8. Through its middle t; beside it nothing; below it nothing.
  const auto process = openProcess("chiba", zenith());
  const auto lightUnder = [&](const core::Vec3& other) {
    return firstValues(answersOf(*process, QueryBuilder().add({0, 0, 0}, {0.5}).add(other, {1}).batch()))[0];
  };
  EXPECT_DOUBLE_EQ(lightUnder({0, 5, 0}), 0.25);
  EXPECT_NEAR(lightUnder({0.6, 5, 0}), std::pow(0.25, 0.8), 1e-15);
  EXPECT_EQ(lightUnder({1.01, 5, 0}), 1.0);
  EXPECT_EQ(lightUnder({0, -5, 0}), 1.0);
  // a sphere around the point: only the part of the chord above it
  EXPECT_NEAR(lightUnder({0, 0.5, 0}), std::pow(0.25, 1.5 / 2.0), 1e-15);
}

TEST(Chiba, AHugeSphereIsCrossedLikeAnyOther) {
  // the square of its radius is infinite
  for (const double transmittance : {0.0, 0.25}) {
    const auto process =
        openProcess("chiba", R"({"sources":[[0,1,0,1]],"transmittance":)" + std::to_string(transmittance) + "}");
    const auto values = firstValues(
        answersOf(*process, QueryBuilder().add({0, 0, 0}, {0.5}).add({0, 5, 0}, {1e300}).add({0, 9, 0}, {1}).batch()));
    EXPECT_NEAR(values[0], transmittance * transmittance, 1e-12);
    EXPECT_NEAR(values[1], transmittance, 1e-12);
    EXPECT_NEAR(values[2], transmittance, 1e-12);
  }
}

TEST(Chiba, SeveralSpheresMultiply) {
  const auto process = openProcess("chiba", zenith());
  QueryBuilder builder;
  for (int i = 0; i < 5; ++i) {
    builder.add({0, 3.0 * i, 0}, {1});
  }
  const auto values = firstValues(answersOf(*process, builder.batch()));
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_DOUBLE_EQ(values[i], std::pow(0.25, 4.0 - static_cast<double>(i)));
  }
}

TEST(Chiba, ABeamWidensTheOtherSpheres) {
  // beam radius 0.5 of an own radius of 2 widens a sphere of radius 1 to 2: 1.2 aside, chord 2·√(4−1.44) = 3.2 of 4
  const auto process = openProcess("chiba", zenith(R"("beamRadius":0.5)"));
  const auto table = answersOf(*process, QueryBuilder().add({0, 0, 0}, {2}).add({1.2, 9, 0}, {1}).batch());
  EXPECT_NEAR(*table[0][0], std::pow(0.25, 0.8), 1e-15);
}

TEST(Chiba, TheAreaOfTheDiscsInCommonDecidesWhenAskedTo) {
  // equal discs of radius 1 at distance 1: common area 2·(π/3 − √3/4) of π; a wholly covered one loses 1 − t
  const auto process = openProcess("chiba", zenith(R"("estimateIntersectionArea":true)"));
  const auto lightUnder = [&](const core::Vec3& other, double radius) {
    return firstValues(answersOf(*process, QueryBuilder().add({0, 0, 0}, {1}).add(other, {radius}).batch()))[0];
  };
  const double common = 2.0 * (std::numbers::pi / 3.0 - std::sqrt(3.0) / 4.0);
  EXPECT_NEAR(lightUnder({1, 7, 0}, 1), 1.0 - 0.75 * common / std::numbers::pi, 1e-15);
  EXPECT_DOUBLE_EQ(lightUnder({0.5, 7, 0}, 3), 0.25);
  EXPECT_DOUBLE_EQ(lightUnder({0.5, 7, 0}, 0.5), 1.0 - 0.75 * 0.25);
  EXPECT_EQ(lightUnder({2.0, 7, 0}, 1), 1.0);
  EXPECT_EQ(lightUnder({0, -7, 0}, 1), 1.0);
}

TEST(Chiba, WeightsAreSharesAndTheBrightestDirectionIsTheirMean) {
  // 3 parts from above, shaded by t = 0.25, and 1 part from +x, free: light (0.75 + 1)/4, direction (1, 0.75)/1.25
  const auto process = openProcess("chiba", R"({"transmittance":0.25,"sources":[[0,7,0,3],[2,0,0,1]]})");
  const auto row = answersOf(*process, QueryBuilder().add({0, 0, 0}, {1, 0, 0, 0}).add({0, 9, 0}, {1}).batch())[0];
  EXPECT_NEAR(*row[0], 1.75 / 4.0, 1e-15);
  EXPECT_NEAR(*row[1], 0.8, 1e-15);
  EXPECT_NEAR(*row[2], 0.6, 1e-15);
  EXPECT_NEAR(*row[3], 0.0, 1e-15);
}

TEST(Chiba, WithoutARadiusTheConfiguredOneCounts) {
  const auto process = openProcess("chiba", zenith(R"("radius":2)"));
  EXPECT_EQ(
      firstValues(answersOf(*process, QueryBuilder().add({1.9, 0, 0}, {0.1}).add({0, 9, 0}, {0}).batch()))[0] < 1.0,
      true);
  EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({2.1, 0, 0}, {0.1}).add({0, 9, 0}, {-1}).batch()))[0],
            1.0);
}

TEST(Chiba, EqualsAllPairsOnRandomSpheres) {
  // the tree against a plain loop over all spheres
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(-10, 10);
  std::uniform_real_distribution<double> size(0.05, 1.5);
  std::vector<std::pair<core::Vec3, double>> spheres;
  QueryBuilder builder;
  for (int i = 0; i < 500; ++i) {
    spheres.push_back({{place(random), place(random), place(random)}, size(random)});
    builder.add(spheres.back().first, {spheres.back().second});
  }
  const auto process = openProcess("chiba", R"({"transmittance":0.8,"sources":[[0.3,1,0.2,1],[-1,0.1,0,2]]})");
  const auto values = firstValues(answersOf(*process, builder.batch()));
  const std::vector<core::Vec3> directions{core::normalised({0.3, 1, 0.2}), core::normalised({-1, 0.1, 0})};
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    double light = 0.0;
    for (std::size_t d = 0; d < 2; ++d) {
      double passing = 1.0;
      for (std::size_t j = 0; j < spheres.size(); ++j) {
        const core::Vec3 between = spheres[j].first - spheres[i].first;
        const double ahead = core::dot(between, directions[d]);
        const double r = spheres[j].second;
        const double half2 = r * r - (core::dot(between, between) - ahead * ahead);
        if (j != i && half2 > 0.0 && ahead + std::sqrt(half2) > 0.0) {
          const double chord = ahead + std::sqrt(half2) - std::max(ahead - std::sqrt(half2), 0.0);
          passing *= std::pow(0.8, chord / (2 * r));
        }
      }
      light += (d == 0 ? 1.0 : 2.0) / 3.0 * passing;
    }
    ASSERT_NEAR(values[i], light, 1e-12) << i;
  }
}

TEST(LightDirections, AreSpreadOverTheSphereAndSumTo1) {
  for (const std::size_t wanted : {std::size_t{1}, std::size_t{20}, std::size_t{100}}) {
    const auto directions = sampleSky({.sampleCount = wanted, .lowerToUpperRatio = 1.0}, {0, 1, 0});
    EXPECT_EQ(directions.size(), wanted <= 8 ? 8U : wanted <= 32 ? 32U : 128U);
    core::Vec3 mean;
    double sum = 0.0;
    for (const auto& light : directions) {
      EXPECT_NEAR(core::length(light.direction), 1.0, 1e-12);
      mean = mean + light.direction * light.weight;
      sum += light.weight;
    }
    EXPECT_NEAR(core::length(mean), 0.0, 1e-12);
    EXPECT_NEAR(sum, 1.0, 1e-12);
  }
}

TEST(LightDirections, LightFromBelowIsWeakerByTheRatio) {
  double above = 0.0;
  double below = 0.0;
  for (const auto& light : sampleSky({.sampleCount = 32, .lowerToUpperRatio = 0.7}, {0, 0, 1})) {
    (light.direction.z > 0.0 ? above : below) += light.weight;
  }
  EXPECT_NEAR(below / above, 0.7, 1e-12);
}

TEST(LightDirections, AnOvercastSkyIsBrightestAbove) {
  // (1 + cos)/3 · (8.6 cos + 0.123) of the zenith against the horizon's band, and the same part of the uniform sky
  const auto directions = sampleSky({.sampleCount = 128, .lowerToUpperRatio = 0.0, .isOvercast = true}, {0, 1, 0});
  const auto uniform = sampleSky({.sampleCount = 128, .lowerToUpperRatio = 0.0}, {0, 1, 0});
  for (std::size_t i = 0; i < directions.size(); ++i) {
    for (std::size_t k = 0; k < directions.size(); ++k) {
      const double a = directions[i].direction.y;
      const double b = directions[k].direction.y;
      if (a > b + 1e-9 && b > 0.0) {
        const auto luminance = [](double c) { return (1 + c) * (8.6 * c + 0.123); };
        ASSERT_NEAR(directions[i].weight / directions[k].weight,
                    luminance(a) / luminance(b) * uniform[i].weight / uniform[k].weight, 1e-9);
      }
    }
  }
}

TEST(LightDirections, EachHasTheLightOfItsPartOfTheSky) {
  // an opaque sphere of radius 1 at the distance 3 covers 1 − cos α of the hemisphere, sin α = 1/3, wherever it stands
  const auto sky = sampleSky({.sampleCount = 32768, .lowerToUpperRatio = 0.0}, {0, 1, 0});
  const double covered = 1.0 - std::sqrt(1.0 - 1.0 / 9.0);
  for (const core::Vec3& way : {core::Vec3{0, 1, 0}, {1, 1, 1}, {1, 1, 0}, {1, 0.6, 0.3}, {-0.2, 0.5, -0.7}}) {
    const core::Vec3 middle = core::normalised(way);
    double light = 0.0;
    for (const auto& direction : sky) {
      light += core::dot(direction.direction, middle) > 1.0 - covered ? direction.weight : 0.0;
    }
    EXPECT_NEAR(light, covered, 0.011 * covered) << way.x << " " << way.y << " " << way.z;
  }
  // a uniform sky: the mean height of its light is 1/2
  double height = 0.0;
  for (const auto& direction : sky) {
    height += direction.weight * direction.direction.y;
  }
  EXPECT_NEAR(height, 0.5, 1e-4);
}

}  // namespace
}  // namespace espalier::environment::chiba_test

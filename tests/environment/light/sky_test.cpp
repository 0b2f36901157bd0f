#include "environment/light/sky.h"

#include <gtest/gtest.h>

#include <cmath>

namespace espalier::environment::sky_test {
namespace {

TEST(Sky, TheGaussRuleIsExactForPolynomials) {
  for (const int count : {1, 2, 5, 12}) {
    for (int degree = 0; degree < 2 * count; ++degree) {
      double integral = 0.0;
      for (const auto& [x, weight] : gaussLegendre(count)) {
        integral += weight * std::pow(x, degree);
      }
      EXPECT_NEAR(integral, 1.0 / (degree + 1), 1e-14) << count << " points, degree " << degree;
    }
  }
}

TEST(Sky, TheRingsGiveTheMomentsOfUniformAndOvercastSkies) {
  // parts of the horizontal irradiance w ∝ L μ dμ: the mean of μ is ∫μ²/∫μ = 2/3 under the uniform sky and
  // ∫(1+2μ)μ²/∫(1+2μ)μ = (1/3 + 1/2)/(1/2 + 2/3) = 5/7 under the overcast one; they add up to 1 around the vertical
  const core::Vec3 up = core::normalised({1, 2, -0.5});
  for (const auto& [kind, mean] : {std::pair(SkyKind::Uniform, 2.0 / 3), std::pair(SkyKind::Overcast, 5.0 / 7)}) {
    double sum = 0.0;
    double found = 0.0;
    core::Vec3 resultant;
    for (const auto& [direction, weight] : skyRings(kind, 5, 7, up, up)) {
      EXPECT_NEAR(core::length(direction), 1.0, 1e-14);
      sum += weight;
      found += weight * core::dot(direction, up);
      resultant = resultant + direction * weight;
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
    EXPECT_NEAR(found, mean, 1e-14);
    EXPECT_NEAR(core::length(core::cross(resultant, up)), 0.0, 1e-14);
  }
}

TEST(Sky, TheClearSkyIsBrightAtTheSunAndAtTheHorizon) {
  // sun at the zenith angle 60°. Relative to the zenith's radiance: at the sun
  // (0.91 + 10 + 0.45)(1 − e^−0.64)/((0.91 + 10 e^−π + 0.45/4)(1 − e^−0.32)), as the formula of the CIE has it
  const double sun = (0.91 + 10 + 0.45) * (1 - std::exp(-0.64)) /
                     ((0.91 + 10 * std::exp(-3 * std::acos(0.5)) + 0.45 / 4) * (1 - std::exp(-0.32)));
  EXPECT_NEAR(skyRadiance(SkyKind::Clear, 0.5, 1.0, 0.5), sun, 1e-12);
  EXPECT_NEAR(sun, 13.5, 0.5);
  EXPECT_NEAR(skyRadiance(SkyKind::Clear, 1.0, 0.5, 0.5), 1.0, 1e-15);
  EXPECT_GT(skyRadiance(SkyKind::Clear, 0.05, 0.0, 0.5), skyRadiance(SkyKind::Clear, 0.9, 0.0, 0.5));
  EXPECT_NEAR(skyRadiance(SkyKind::Overcast, 1e-9, 0, 1) * 3, skyRadiance(SkyKind::Overcast, 1.0, 0, 1), 1e-8);
}

}  // namespace
}  // namespace espalier::environment::sky_test

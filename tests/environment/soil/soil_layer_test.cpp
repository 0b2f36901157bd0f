#include "environment/soil/soil_layer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace espalier::environment::soil_layer_test {
namespace {

TEST(SoilLayer, FollowsVanGenuchtenAndMualem) {
  // Celia et al. (1990): θ = θr + (θs − θr)/(1 + |αh|^n)^m and
  // K = Ks (1 − |αh|^(n−1) (1 + |αh|^n)^−m)²/(1 + |αh|^n)^(m/2), with m = 1 − 1/n; at h = −75 cm with n = 2
  const SoilLayer soil{0.102, 0.368, 0.0335, 2, 0.00922, 0};
  const double s = 0.0335 * 75;
  EXPECT_NEAR(soil.content(-75), 0.102 + 0.266 / std::sqrt(1 + s * s), 1e-15);
  const double film = 1 - s / std::sqrt(1 + s * s);
  EXPECT_NEAR(soil.conductivityAt(-75) / (0.00922 * film * film / std::pow(1 + s * s, 0.25)), 1, 1e-12);
  EXPECT_EQ(soil.content(0), 0.368);
  EXPECT_EQ(soil.conductivityAt(3), 0.00922);
}

TEST(SoilLayer, CapacityIsTheSlopeAndHeadAtTheInverseOfTheContent) {
  const SoilLayer soil{0.078, 0.43, 3.6, 1.56, 0.25, 1e-3};
  for (const double head : {-100.0, -3.0, -0.5, -0.01, 0.2, 4.0}) {
    const double step = 1e-5 * std::abs(head);
    EXPECT_NEAR((soil.content(head + step) - soil.content(head - step)) / (2 * step) / soil.capacity(head), 1, 1e-6);
    EXPECT_NEAR(soil.headAt(soil.content(head)) / head, 1, 1e-9);
  }
  EXPECT_EQ(soil.headAt(0.078), -1e7);
}

}  // namespace
}  // namespace espalier::environment::soil_layer_test

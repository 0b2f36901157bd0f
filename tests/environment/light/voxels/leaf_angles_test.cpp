#include "environment/light/voxels/leaf_angles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "environment/light/sky.h"

namespace espalier::environment::leaf_angles_test {
namespace {

using std::numbers::pi;

TEST(LeafAngles, TheMeanProjectionOverTheHemisphereIsOneHalf) {
  // a flat leaf turned to all directions evenly projects half of its area, whatever its own angle: ∫ G sin θ dθ = 1/2.
  // Campbell's formula is an approximation, by his account within 2 %
  for (std::size_t k = 0; k < kLeafAngleNames.size(); ++k) {
    const auto angles = static_cast<LeafAngles>(k);
    double mean = 0.0;
    for (const auto& [cosine, weight] : gaussLegendre(40)) {
      mean += weight * leafProjection(angles, cosine, 1.7);
    }
    EXPECT_NEAR(mean, 0.5, angles == LeafAngles::Ellipsoidal ? 0.01 : 1e-3) << kLeafAngleNames[k];
  }
}

TEST(LeafAngles, FromAboveTheProjectionIsTheMeanCosineOfTheLeafAngle) {
  // G(0) = ∫ cos α g(α) dα: with ∫ cos α cos 2α = 1/3 and ∫ cos α cos 4α = −1/15 over 0 … π/2
  EXPECT_NEAR(leafProjection(LeafAngles::Planophile, 1, 1), 2 / pi * (1 + 1.0 / 3), 1e-6);
  EXPECT_NEAR(leafProjection(LeafAngles::Erectophile, 1, 1), 2 / pi * (1 - 1.0 / 3), 1e-6);
  EXPECT_NEAR(leafProjection(LeafAngles::Plagiophile, 1, 1), 2 / pi * (1 + 1.0 / 15), 1e-6);
  EXPECT_NEAR(leafProjection(LeafAngles::Extremophile, 1, 1), 2 / pi * (1 - 1.0 / 15), 1e-6);
  EXPECT_NEAR(leafProjection(LeafAngles::Uniform, 1, 1), 2 / pi, 1e-6);
  EXPECT_EQ(leafProjection(LeafAngles::Vertical, 1, 1), 0.0);
  EXPECT_EQ(leafProjection(LeafAngles::Horizontal, 0.3, 1), 0.3);
}

TEST(LeafAngles, TheEllipsoidWithEqualAxesIsSpherical) {
  for (const double cosine : {1.0, 0.7, 0.2}) {
    EXPECT_NEAR(leafProjection(LeafAngles::Ellipsoidal, cosine, 1), 0.5, 0.005);
  }
  EXPECT_GT(leafProjection(LeafAngles::Ellipsoidal, 1, 3), 0.7);
}

}  // namespace
}  // namespace espalier::environment::leaf_angles_test

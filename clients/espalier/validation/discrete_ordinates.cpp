#include "clients/espalier/validation/discrete_ordinates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/core/elementary.h"

namespace espalier::validation {

namespace {

using std::numbers::pi;

constexpr std::size_t kHalf = 8;         // directions down, and as many up
constexpr std::size_t kAll = 2 * kHalf;  // the first half down
constexpr std::size_t kLayers = 48;      // thin ones in which the source is even
constexpr double kProjection = 0.5;      // G of leaves without a preferred direction
using Directions = std::array<double, kAll>;

/// Points and weights of Gauss and Legendre on 0 to 1.
constexpr std::array<double, 4> kPoints{0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
constexpr std::array<double, 4> kWeights{0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                         0.1012285362903763};

class SphericalLayer {
 public:
  SphericalLayer(double leafAreaIndex, double rho, double tau, double ground, std::optional<double> zenithDegrees)
      : rho_(rho), tau_(tau), ground_(ground), thickness_(leafAreaIndex / static_cast<double>(kLayers)) {
    for (std::size_t k = 0; k < 4; ++k) {
      for (const double sign : {-1.0, 1.0}) {
        const std::size_t i = sign < 0.0 ? 3 - k : 4 + k;
        cosines_[i] = 0.5 * (1.0 + sign * kPoints[k]);
        cosines_[kHalf + i] = -cosines_[i];
        weights_[i] = weights_[kHalf + i] = 0.5 * kWeights[k];
        passed_[i] = passed_[kHalf + i] = core::exp(-kProjection * thickness_ / cosines_[i]);
      }
    }
    for (std::size_t from = 0; from < kAll; ++from) {
      setScattered(from, kernelFrom(cosines_[from]));
    }
    first_.assign(kLayers, Directions{});
    if (zenithDegrees) {
      addBeam(core::cos(*zenithDegrees * pi / 180.0), leafAreaIndex);
    } else {
      sky_ = 1.0 / pi;  // gives a horizontal plane 1
    }
  }

  [[nodiscard]] LayerFluxes solve() {
    source_ = first_;
    constexpr int kMostRounds = 3000;
    double up = 0.0;
    double down = 0.0;
    for (int round = 0; round < kMostRounds; ++round) {
      const double before = up + down;
      down = passDown();
      up = passUp(ground_ * down / pi);
      scatter();
      if (std::abs(up + down - before) < 1e-10) {
        break;
      }
    }
    return {up, 1.0 - up - (1.0 - ground_) * down, down};
  }

 private:
  /// Part of the light of a direction that leaves scatter in the others: the mean over all azimuths, scaled so that
  /// (ρ + τ)/2 of it is scattered in all.
  [[nodiscard]] Directions kernelFrom(double cosine) const {
    constexpr int kAzimuths = 32;
    Directions kernel{};
    double sum = 0.0;
    for (std::size_t i = 0; i < kAll; ++i) {
      const double sines = std::sqrt((1.0 - cosine * cosine) * (1.0 - cosines_[i] * cosines_[i]));
      for (int n = 0; n < kAzimuths; ++n) {
        const double turn = std::clamp(cosine * cosines_[i] + sines * core::cos(pi * (n + 0.5) / kAzimuths), -1.0, 1.0);
        const double angle = core::acos(turn);
        const double back = (core::sin(angle) - angle * turn) / (3.0 * pi);
        kernel[i] += (rho_ * back + tau_ * (back + turn / 3.0)) / (pi * kAzimuths);
      }
      sum += 2.0 * pi * kernel[i] * weights_[i];
    }
    for (double& part : kernel) {
      part *= sum > 0.0 ? 0.5 * (rho_ + tau_) / sum : 0.0;
    }
    return kernel;
  }
  void setScattered(std::size_t from, const Directions& kernel) {
    for (std::size_t to = 0; to < kAll; ++to) {
      kernels_[to][from] = kernel[to];
    }
  }

  /// The light that leaves scatter of a beam that gives a horizontal plane 1.
  void addBeam(double cosine, double leafAreaIndex) {
    const Directions kernel = kernelFrom(cosine);
    for (std::size_t layer = 0; layer < kLayers; ++layer) {
      const auto above = [&](std::size_t k) {
        return core::exp(-kProjection * static_cast<double>(k) * thickness_ / cosine);
      };
      const double mean = (above(layer) - above(layer + 1)) / (kProjection * thickness_);
      for (std::size_t i = 0; i < kAll; ++i) {
        first_[layer][i] = kernel[i] * mean;
      }
    }
    beamAtGround_ = core::exp(-kProjection * leafAreaIndex / cosine);
  }

  /// Light of a direction after a layer; its mean in the layer is kept.
  [[nodiscard]] double passLayer(std::size_t layer, std::size_t direction, double light) {
    const double cosine = std::abs(cosines_[direction]);
    const double source = source_[layer][direction] / kProjection;
    const double after = source + (light - source) * passed_[direction];
    mean_[layer][direction] = source + (light - after) * cosine / (kProjection * thickness_);
    return after;
  }
  [[nodiscard]] double passDown() {
    double down = beamAtGround_;
    for (std::size_t i = 0; i < kHalf; ++i) {
      double light = sky_;
      for (std::size_t layer = 0; layer < kLayers; ++layer) {
        light = passLayer(layer, i, light);
      }
      down += 2.0 * pi * light * cosines_[i] * weights_[i];
    }
    return down;
  }
  [[nodiscard]] double passUp(double fromGround) {
    double up = 0.0;
    for (std::size_t i = 0; i < kHalf; ++i) {
      double light = fromGround;
      for (std::size_t layer = kLayers; layer-- > 0;) {
        light = passLayer(layer, kHalf + i, light);
      }
      up += 2.0 * pi * light * cosines_[i] * weights_[i];
    }
    return up;
  }
  void scatter() {
    for (std::size_t layer = 0; layer < kLayers; ++layer) {
      for (std::size_t to = 0; to < kAll; ++to) {
        double sum = 0.0;
        for (std::size_t from = 0; from < kAll; ++from) {
          sum += kernels_[to][from] * weights_[from] * mean_[layer][from];
        }
        source_[layer][to] = first_[layer][to] + 2.0 * pi * sum;
      }
    }
  }

  double rho_, tau_, ground_, thickness_;
  double sky_ = 0.0;                        // radiance
  double beamAtGround_ = 0.0;               // of the beam, past all leaves
  Directions passed_{};                     // light past the leaves of a thin layer, as a part
  Directions cosines_{}, weights_{};        // of the zenith angle of travel, above 0 down
  std::array<Directions, kAll> kernels_{};  // (to, from)
  std::vector<Directions> first_, source_;  // (layer): light that is scattered once, and all; by a unit of leaf area
  std::vector<Directions> mean_ = std::vector<Directions>(kLayers);  // (layer): radiance
};

}  // namespace

LayerFluxes sphericalLayer(double leafAreaIndex, double rho, double tau, double ground,
                           std::optional<double> zenithDegrees) {
  return SphericalLayer(leafAreaIndex, rho, tau, ground, zenithDegrees).solve();
}

}  // namespace espalier::validation

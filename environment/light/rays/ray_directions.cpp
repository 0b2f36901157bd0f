#include "environment/light/rays/ray_directions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::environment {

using std::numbers::pi;

namespace {

constexpr int kMostTurns = 16;
constexpr int kDirectionsOfAllTurns = 2048;  // more are not needed: a lattice of so many has no visible steps

const double kGolden = (3.0 - std::sqrt(5.0)) / 2.0;  // part of the circle between one direction and the next

double fractionAboveFloor(double x) {
  return x - std::floor(x);
}

/// By how many numbers a lattice goes on from zone to zone beside their width, so that its own directions turn nearly
/// by the golden angle too.
int strideFor(int turns) {
  int best = 0;
  for (int stride = 1; stride < turns; ++stride) {
    const auto missed = [&](int s) { return std::abs(fractionAboveFloor((turns + s) * kGolden) - kGolden); };
    best = missed(stride) < missed(best) ? stride : best;
  }
  return best;
}

}  // namespace

RayDirections::RayDirections(int count) {
  for (int size = count;; size /= 2) {
    firstOf_.push_back(static_cast<std::uint32_t>(lattices_.size()));
    const int turns = std::clamp(kDirectionsOfAllTurns / size, 1, kMostTurns);
    const int stride = strideFor(turns);
    for (int turn = 0; turn < turns; ++turn) {
      lattices_.push_back({all_.size(), static_cast<std::size_t>(size)});
      // together the lattices of a size are one of `size` times `turns` directions, of which each takes one in each
      // zone
      for (int zone = 0; zone < size; ++zone) {
        const int number = zone * turns + (turn + zone * stride) % turns;
        const double height = 1.0 - (2.0 * number + 1.0) / (size * turns);
        const double width = std::sqrt(1.0 - height * height);
        const double angle = 2.0 * pi * fractionAboveFloor(number * kGolden);
        all_.push_back({width * core::cos(angle), height, width * core::sin(angle)});
      }
    }
    if (size / 2 < kLeast) {
      break;
    }
  }
  firstOf_.push_back(static_cast<std::uint32_t>(lattices_.size()));
}

RayDirections::Lattice RayDirections::latticeOf(unsigned thinning, std::uint32_t seed) const {
  const unsigned size = std::min(thinning, lastThinning());
  return lattices_[firstOf_[size] + seed % (firstOf_[size + 1] - firstOf_[size])];
}

RayDirections::Lattice RayDirections::otherLatticeOf(unsigned thinning, std::uint32_t seed) const {
  const unsigned size = std::min(thinning, lastThinning());
  const std::uint32_t turns = firstOf_[size + 1] - firstOf_[size];
  return lattices_[firstOf_[size] + (seed % turns + turns / 2) % turns];
}

RayDirections::Lattice RayDirections::allLatticesOf(unsigned thinning) const {
  const unsigned size = std::min(thinning, lastThinning());
  const Lattice& first = lattices_[firstOf_[size]];
  return {first.begin, first.count * (firstOf_[size + 1] - firstOf_[size])};
}

}  // namespace espalier::environment

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// The directions in which triangles look: Fibonacci lattices over the whole sphere, which are the same in every step.
/// There are lattices of `count` directions, of half as many, a quarter and so on down to kLeast (thinning 0, 1, 2 …).
/// There are several lattices of every size, which together are a lattice too. So the triangles of one leaf, each with
/// few directions, together look in many.
class RayDirections {
 public:
  static constexpr int kLeast = 16;
  struct Lattice {
    std::size_t begin = 0;  // in all()
    std::size_t count = 0;
  };

  /// At least 1. O(count · log count).
  explicit RayDirections(int count);

  /// The lattice of a triangle: `seed` chooses among those of a size. A thinning beyond the last is the last.
  [[nodiscard]] Lattice latticeOf(unsigned thinning, std::uint32_t seed) const;
  /// Another one of the same size, half of them further on; the same when there is only one.
  [[nodiscard]] Lattice otherLatticeOf(unsigned thinning, std::uint32_t seed) const;
  /// All of that size, as one.
  [[nodiscard]] Lattice allLatticesOf(unsigned thinning) const;
  /// Unit vectors of all lattices, concatenated; the first `count` are the first lattice.
  [[nodiscard]] const std::vector<core::Vec3>& all() const { return all_; }
  [[nodiscard]] std::span<const Lattice> lattices() const { return lattices_; }
  [[nodiscard]] unsigned lastThinning() const { return static_cast<unsigned>(firstOf_.size()) - 2; }

 private:
  std::vector<core::Vec3> all_;
  std::vector<Lattice> lattices_;       // by thinning
  std::vector<std::uint32_t> firstOf_;  // of each thinning in lattices_, then their number
};

}  // namespace espalier::environment

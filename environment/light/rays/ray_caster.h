#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// Rays against triangles by Embree, in single precision. Results are the same for any number of threads and on every
/// x86-64 processor.
///
/// With a repetition the triangles are those of one plot, which repeats without end along two directions of space.
class RayCaster {
 public:
  static constexpr std::uint32_t kMiss = std::numeric_limits<std::uint32_t>::max();
  struct Repetition {
    std::array<int, 2> axes{0, 2};        // indices of the horizontal world axes
    std::array<double, 2> low{}, high{};  // of the plot along these
  };

  /// A place in or near a scene that is far from 0 beside its size; 0 along the axes where it is not far. The same for
  /// scenes that differ little. O(vertices).
  [[nodiscard]] static core::Vec3 middleOf(std::span<const core::Vec3> vertices);

  /// `middle`: of the scene, from which single precision counts. `threads` build the tree. `widestInstructions` are
  /// Embree's (sse2, sse4.2, avx): hits do not depend on them. Wider ones than avx have fused multiply-add, which
  /// decides some rays at edges otherwise. O(n log n).
  RayCaster(std::span<const core::Vec3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
            const std::optional<Repetition>& repetition, const core::Vec3& middle, unsigned threads,
            const std::string& widestInstructions = "avx");
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// A triangle and whether the ray meets its front, the side from which the corners run counterclockwise.
  struct Hit {
    std::uint32_t triangle = kMiss;  // kMiss: there is none
    bool isFront = false;
  };
  /// The first triangle on a ray, of equally near ones that with the smallest number, so that a hit does not depend on
  /// how the tree was built. `direction` is a unit vector, not horizontal when the plot repeats itself. Hits nearer
  /// than `margin` are left out. May be called by several threads.
  [[nodiscard]] Hit firstHit(const core::Vec3& origin, const core::Vec3& direction, double margin) const;
  /// Whether a ray meets no triangle. Faster than the first hit.
  [[nodiscard]] bool isFree(const core::Vec3& origin, const core::Vec3& direction, double margin) const;
  /// The distance from a triangle at which its rays start: a length that single precision resolves there, also when
  /// other parts of the scene are far away. It is a power of two. In a plot that repeats itself it is margin().
  [[nodiscard]] double marginOf(std::uint32_t triangle) const;
  /// A length that single precision resolves everywhere in the scene, a power of two.
  [[nodiscard]] double margin() const;
  [[nodiscard]] const core::Vec3& middle() const;

 private:
  struct Tree;
  template <typename Cast>
  [[nodiscard]] Hit alongPlots(const core::Vec3& origin, const core::Vec3& direction, double margin,
                               const Cast& cast) const;

  std::unique_ptr<Tree> tree_;
};

}  // namespace espalier::environment

#pragma once

#include <memory>
#include <span>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// A box with sides along the axes.
struct Bounds {
  core::Vec3 low;
  core::Vec3 high;
};

/// Finds the boxes near a point or on a ray, with Embree's tree over user geometry. Embree computes in single precision
/// and with different instructions on different machines. Here it only leaves boxes out, on the safe side: boxes and
/// distances are widened by more than its rounding. The caller decides in double precision. So results are the same bit
/// by bit on every machine if the caller does not depend on the order of visits. Building is O(n log n) by one thread.
class BoxTree {
 public:
  explicit BoxTree(std::span<const Bounds> boxes);
  ~BoxTree();
  BoxTree(BoxTree&&) noexcept;
  BoxTree& operator=(BoxTree&&) noexcept;

  /// Calls `visit(index)` for all boxes within `radius` of a point (and perhaps some more); it returns the radius that
  /// still matters, at most the present one.
  template <typename Visit>
  void visitNear(const core::Vec3& point, double radius, const Visit& visit) const {
    near(point, radius,
         {[](const void* data, unsigned index) { return (*static_cast<const Visit*>(data))(index); }, &visit});
  }
  /// The same for all boxes on a ray up to `reach`; `direction` is a unit vector. `visit` returns the reach that still
  /// matters.
  template <typename Visit>
  void visitRay(const core::Vec3& origin, const core::Vec3& direction, double reach, const Visit& visit) const {
    along(origin, direction, reach,
          {[](const void* data, unsigned index) { return (*static_cast<const Visit*>(data))(index); }, &visit});
  }

 private:
  struct Visitor {
    double (*call)(const void* data, unsigned index);
    const void* data;
  };
  struct Tree;

  void near(const core::Vec3& point, double radius, Visitor visitor) const;
  void along(const core::Vec3& origin, const core::Vec3& direction, double reach, Visitor visitor) const;

  std::unique_ptr<Tree> tree_;
};

}  // namespace espalier::environment

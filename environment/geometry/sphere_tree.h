#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::environment {

struct Sphere {
  core::Vec3 centre;
  double radius = 0.0;
};

/// The order of spheres: by x, y, z, radius.
[[nodiscard]] inline auto orderKeyOf(const Sphere& s) {
  return std::tuple(s.centre.x, s.centre.y, s.centre.z, s.radius);
}

/// Distinct spheres, each with the number of times it was given. So products over them do not depend on the order in
/// which they were given, and equal spheres cost as much as one.
struct DistinctSpheres {
  std::vector<Sphere> spheres;         // sorted by x, y, z, radius
  std::vector<std::uint32_t> count;    // how often each was given
  std::vector<std::uint32_t> indexOf;  // of the given ones in `spheres`
};

/// O(n log n).
[[nodiscard]] DistinctSpheres distinctSpheres(const std::vector<Sphere>& given);

/// A half-line from `origin` along the unit vector `direction`, up to `reach`.
struct Ray {
  core::Vec3 origin;
  core::Vec3 direction;
  double reach = 0.0;
};

/// A tree of boxes over distinct spheres that finds those near a ray. It is the same tree for the same set of spheres
/// in any order, and visits them in an order that depends only on the set and the ray. Building is O(n log n), a visit
/// O(log n + spheres found) for spheres that do not all overlap.
class SphereTree {
 public:
  explicit SphereTree(std::vector<Sphere> spheres);

  /// Indices of the spheres, neighbours near each other.
  [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }

  /// Calls `visit(index, sphere)` for every sphere whose box, enlarged by `margin` to all sides, the ray meets, until
  /// it returns false.
  template <typename Visit>
  void visitRay(const Ray& ray, double margin, const Visit& visit) const {
    if (nodes_.empty()) {
      return;
    }
    const std::array<double, 3> origin{ray.origin.x, ray.origin.y, ray.origin.z};
    // not infinity, because infinity times 0 is NaN
    const auto inverseOf = [](double component) { return component == 0.0 ? 1e300 : 1.0 / component; };
    const std::array<double, 3> inverse{inverseOf(ray.direction.x), inverseOf(ray.direction.y),
                                        inverseOf(ray.direction.z)};
    std::array<std::uint32_t, 64> stack;
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const Node& node = nodes_[stack[--depth]];
      if (!meets(node, origin, inverse, margin, ray.reach)) {
        continue;
      }
      if (node.children == 0) {
        for (std::uint32_t k = node.begin; k < node.end; ++k) {
          if (!visit(order_[k], spheres_[k])) {
            return;
          }
        }
        continue;
      }
      stack[depth++] = node.children + 1;
      stack[depth++] = node.children;
    }
  }

 private:
  struct Node {
    std::array<double, 3> low{};
    std::array<double, 3> high{};
    std::uint32_t begin = 0;
    std::uint32_t end = 0;       // spheres order_[begin, end)
    std::uint32_t children = 0;  // the first of two neighbours; 0: a leaf
  };

  static bool meets(const Node& node, const std::array<double, 3>& origin, const std::array<double, 3>& inverse,
                    double margin, double reach) {
    double near = 0.0;
    double far = reach;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double a = (node.low[axis] - margin - origin[axis]) * inverse[axis];
      const double b = (node.high[axis] + margin - origin[axis]) * inverse[axis];
      const double first = a < b ? a : b;
      const double last = a < b ? b : a;
      near = first > near ? first : near;
      far = last < far ? last : far;
    }
    return near <= far;
  }

  void build(std::uint32_t node);

  static constexpr std::uint32_t kLeafSize = 4;

  std::vector<Sphere> spheres_;       // as order_, once built
  std::vector<std::uint32_t> order_;  // sphere indices grouped by leaf
  std::vector<Node> nodes_;           // the root first
};

}  // namespace espalier::environment

#include "environment/geometry/point_tree.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "engine/core/check.h"
#include "environment/geometry/interval.h"

namespace espalier::environment {

namespace {

using core::Vec3;

/// Squared distance of a box: rounded, too, never more than that of a point in it.
double squaredDistance(const Vec3& p, const Vec3& low, const Vec3& high) {
  const Vec3 gap{outside(p.x, low.x, high.x), outside(p.y, low.y, high.y), outside(p.z, low.z, high.z)};
  return core::dot(gap, gap);
}

}  // namespace

PointTree::PointTree(std::span<const Vec3> points) : points_(points), order_(points.size()) {
  ESPALIER_CHECK(points.size() < 0xFFFFFFFFU);
  std::iota(order_.begin(), order_.end(), 0U);
  if (points.empty()) {
    return;
  }
  nodes_.emplace_back();
  nodes_.front().end = static_cast<std::uint32_t>(points.size());
  for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
    build(node);
  }
}

void PointTree::build(std::uint32_t index) {
  Node node = nodes_[index];
  node.first = order_[node.begin];
  node.low = node.high = points_[order_[node.begin]];
  for (std::uint32_t k = node.begin; k < node.end; ++k) {
    const Vec3& p = points_[order_[k]];
    node.first = std::min(node.first, order_[k]);
    node.low = {std::min(node.low.x, p.x), std::min(node.low.y, p.y), std::min(node.low.z, p.z)};
    node.high = {std::max(node.high.x, p.x), std::max(node.high.y, p.y), std::max(node.high.z, p.z)};
  }
  if (node.end - node.begin > kLeafSize) {
    const Vec3 side = node.high - node.low;
    const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
    const std::uint32_t middle = node.begin + (node.end - node.begin) / 2;
    std::nth_element(order_.begin() + node.begin, order_.begin() + middle, order_.begin() + node.end,
                     [&](std::uint32_t a, std::uint32_t b) {
                       return std::pair(component(points_[a], axis), a) < std::pair(component(points_[b], axis), b);
                     });
    node.children = static_cast<std::uint32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[node.children].begin = node.begin;
    nodes_[node.children].end = middle;
    nodes_[node.children + 1].begin = middle;
    nodes_[node.children + 1].end = node.end;
  }
  nodes_[index] = node;
}

std::optional<std::uint32_t> PointTree::nearestOther(std::uint32_t point, double most) const {
  // candidates are compared by distance, then index; before the first one everything within `most` is better
  struct Open {
    double squared;
    std::uint32_t first;
    std::uint32_t node;
  };
  const Vec3& own = points_[point];
  std::pair<double, std::uint32_t> best{most, 0xFFFFFFFFU};
  const auto opened = [&](std::uint32_t node) {
    return Open{squaredDistance(own, nodes_[node].low, nodes_[node].high), nodes_[node].first, node};
  };
  std::array<Open, 64> open;
  std::size_t depth = 0;
  open[depth++] = opened(0);
  while (depth > 0) {
    const Open next = open[--depth];
    if (!(std::pair(next.squared, next.first) < best)) {
      continue;
    }
    const Node& node = nodes_[next.node];
    if (node.children == 0) {
      for (std::uint32_t k = node.begin; k < node.end; ++k) {
        const Vec3 way = points_[order_[k]] - own;
        if (order_[k] != point) {
          best = std::min(best, std::pair(core::dot(way, way), order_[k]));
        }
      }
      continue;
    }
    // the nearer one is looked at first
    Open near = opened(node.children);
    Open far = opened(node.children + 1);
    if (std::pair(far.squared, far.first) < std::pair(near.squared, near.first)) {
      std::swap(near, far);
    }
    open[depth++] = far;
    open[depth++] = near;
  }
  return best.second == 0xFFFFFFFFU ? std::nullopt : std::optional(best.second);
}

}  // namespace espalier::environment

#include "environment/geometry/kernel_tree.h"

#include <algorithm>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::environment {

KernelTree::KernelTree(std::vector<WeightedPoint> points, bool isExact)
    : isExact_(isExact), points_(std::move(points)) {
  for (std::size_t i = 0; i < kNodes; ++i) {
    chebyshev_[i] = core::cos(std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(kNodes));
  }
  if (points_.empty()) {
    return;
  }
  std::sort(points_.begin(), points_.end());
  double lowX = points_[0].x;
  double highX = lowX;
  double lowY = points_[0].y;
  double highY = lowY;
  for (const WeightedPoint& point : points_) {
    lowX = std::min(lowX, point.x);
    highX = std::max(highX, point.x);
    lowY = std::min(lowY, point.y);
    highY = std::max(highY, point.y);
  }
  Node root;
  root.x = lowX + (highX - lowX) / 2.0;
  root.y = lowY + (highY - lowY) / 2.0;
  root.half = std::max(highX - lowX, highY - lowY) / 2.0;
  root.end = static_cast<std::uint32_t>(points_.size());
  nodes_.push_back(root);
  build(0, 0);
}

void KernelTree::build(std::uint32_t index, int depth) {
  const Node node = nodes_[index];
  if (!isExact_) {
    interpolate(nodes_[index]);
  }
  if (node.end - node.begin <= kLeafSize || depth == kMaximumDepth || !(node.half > 0.0)) {
    return;
  }
  // four quarters; a stable partition keeps the sorted order within each
  const auto first = points_.begin() + node.begin;
  const auto last = points_.begin() + node.end;
  const auto isLeft = [&](const WeightedPoint& p) { return p.x < node.x; };
  const auto isBelow = [&](const WeightedPoint& p) { return p.y < node.y; };
  const auto middle = std::stable_partition(first, last, isLeft);
  const std::array bounds{first, std::stable_partition(first, middle, isBelow), middle,
                          std::stable_partition(middle, last, isBelow), last};
  nodes_[index].isLeaf = false;
  for (std::size_t quarter = 0; quarter < 4; ++quarter) {
    if (bounds[quarter] == bounds[quarter + 1]) {
      continue;
    }
    Node child;
    child.half = node.half / 2.0;
    child.x = node.x + (quarter < 2 ? -child.half : child.half);
    child.y = node.y + (quarter % 2 == 0 ? -child.half : child.half);
    child.begin = static_cast<std::uint32_t>(bounds[quarter] - points_.begin());
    child.end = static_cast<std::uint32_t>(bounds[quarter + 1] - points_.begin());
    const auto place = static_cast<std::uint32_t>(nodes_.size());
    nodes_[index].children[quarter] = place;
    nodes_.push_back(child);
    build(place, depth + 1);
  }
}

void KernelTree::interpolate(Node& node) const {
  if (node.end - node.begin <= kNodes * kNodes) {
    return;
  }
  // the interpolation polynomial of each node at a point's place
  const auto basis = [&](double u) {
    std::array<double, kNodes> values{};
    for (std::size_t i = 0; i < kNodes; ++i) {
      double value = 1.0;
      for (std::size_t k = 0; k < kNodes; ++k) {
        if (k != i) {
          value *= (u - chebyshev_[k]) / (chebyshev_[i] - chebyshev_[k]);
        }
      }
      values[i] = value;
    }
    return values;
  };
  for (std::uint32_t p = node.begin; p < node.end; ++p) {
    const WeightedPoint& point = points_[p];
    const auto across = basis(node.half > 0.0 ? (point.x - node.x) / node.half : 0.0);
    const auto along = basis(node.half > 0.0 ? (point.y - node.y) / node.half : 0.0);
    for (std::size_t j = 0; j < kNodes; ++j) {
      for (std::size_t i = 0; i < kNodes; ++i) {
        node.weights[j * kNodes + i] += point.weight * across[i] * along[j];
      }
    }
  }
}

}  // namespace espalier::environment

#include "environment/geometry/sphere_tree.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace espalier::environment {

DistinctSpheres distinctSpheres(const std::vector<Sphere>& given) {
  std::vector<std::uint32_t> order(given.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return orderKeyOf(given[a]) < orderKeyOf(given[b]); });
  DistinctSpheres distinct;
  distinct.indexOf.resize(given.size());
  for (const std::uint32_t i : order) {
    if (distinct.spheres.empty() || orderKeyOf(distinct.spheres.back()) != orderKeyOf(given[i])) {
      distinct.spheres.push_back(given[i]);
      distinct.count.push_back(0);
    }
    ++distinct.count.back();
    distinct.indexOf[i] = static_cast<std::uint32_t>(distinct.spheres.size() - 1);
  }
  return distinct;
}

SphereTree::SphereTree(std::vector<Sphere> spheres) : spheres_(std::move(spheres)), order_(spheres_.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  if (spheres_.empty()) {
    return;
  }
  nodes_.reserve(spheres_.size());
  Node root;
  root.end = static_cast<std::uint32_t>(spheres_.size());
  nodes_.push_back(root);
  build(0);
  std::vector<Sphere> grouped;
  grouped.reserve(spheres_.size());
  for (const std::uint32_t sphere : order_) {
    grouped.push_back(spheres_[sphere]);
  }
  spheres_ = std::move(grouped);
}

void SphereTree::build(std::uint32_t index) {
  Node node = nodes_[index];
  const auto begin = order_.begin() + node.begin;
  const auto end = order_.begin() + node.end;
  node.low.fill(INFINITY);
  node.high.fill(-INFINITY);
  for (auto sphere = begin; sphere != end; ++sphere) {
    const Sphere& s = spheres_[*sphere];
    const std::array<double, 3> centre{s.centre.x, s.centre.y, s.centre.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.low[axis] = std::min(node.low[axis], centre[axis] - s.radius);
      node.high[axis] = std::max(node.high[axis], centre[axis] + s.radius);
    }
  }
  // halves along the longest side; all members of a sphere decide
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (node.high[k] - node.low[k] > node.high[axis] - node.low[axis]) {
      axis = k;
    }
  }
  const auto isBefore = [&](std::uint32_t a, std::uint32_t b) {
    const auto along = [&](const Sphere& s) { return axis == 0 ? s.centre.x : axis == 1 ? s.centre.y : s.centre.z; };
    return std::tuple(along(spheres_[a]), orderKeyOf(spheres_[a])) <
           std::tuple(along(spheres_[b]), orderKeyOf(spheres_[b]));
  };
  if (node.end - node.begin <= kLeafSize) {
    std::sort(begin, end, isBefore);
    nodes_[index] = node;
    return;
  }
  const std::uint32_t middle = node.begin + (node.end - node.begin) / 2;
  std::nth_element(begin, order_.begin() + middle, end, isBefore);
  node.children = static_cast<std::uint32_t>(nodes_.size());
  nodes_[index] = node;
  Node child;
  child.begin = node.begin;
  child.end = middle;
  nodes_.push_back(child);
  child.begin = middle;
  child.end = node.end;
  nodes_.push_back(child);
  build(node.children);
  build(node.children + 1);
}

}  // namespace espalier::environment

#include "environment/geometry/disc_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace espalier::environment {

namespace {

using core::Vec3;

}  // namespace

DiscTree::DiscTree(std::vector<Disc> discs)
    : discs_(std::move(discs)), isRemoved_(discs_.size(), 0), order_(discs_.size()), leafOf_(discs_.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  if (discs_.empty()) {
    return;
  }
  nodes_.emplace_back();
  nodes_.front().end = static_cast<std::uint32_t>(discs_.size());
  for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
    build(node);
  }
  grouped_.reserve(discs_.size());
  for (const std::uint32_t disc : order_) {
    grouped_.push_back(discs_[disc]);
  }
  // maxima from the leaves up: children come after their parents
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    update(*node);
  }
}

void DiscTree::build(std::uint32_t index) {
  const std::uint32_t begin = nodes_[index].begin;
  const std::uint32_t end = nodes_[index].end;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low{kInfinity, kInfinity, kInfinity};
  Vec3 high{-kInfinity, -kInfinity, -kInfinity};
  for (std::uint32_t k = begin; k < end; ++k) {
    const Vec3& c = discs_[order_[k]].centre;
    low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
    high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
  }
  nodes_[index].low = low;
  nodes_[index].high = high;
  if (end - begin <= kLeafSize) {
    for (std::uint32_t k = begin; k < end; ++k) {
      leafOf_[order_[k]] = index;
    }
    return;
  }
  // halve at the median of the longest side
  const Vec3 side = high - low;
  const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return component(discs_[a].centre, axis) < component(discs_[b].centre, axis);
                   });
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_[index].children = children;
  nodes_.resize(nodes_.size() + 2);
  nodes_[children].begin = begin;
  nodes_[children].end = middle;
  nodes_[children].parent = index;
  nodes_[children + 1].begin = middle;
  nodes_[children + 1].end = end;
  nodes_[children + 1].parent = index;
}

void DiscTree::update(Node& node) const {
  node.maximumRank = -1;
  node.maximumRadius = -std::numeric_limits<double>::infinity();
  if (node.children != 0) {
    for (const std::uint32_t child : {node.children, node.children + 1}) {
      node.maximumRank = std::max(node.maximumRank, nodes_[child].maximumRank);
      node.maximumRadius = std::max(node.maximumRadius, nodes_[child].maximumRadius);
    }
    return;
  }
  for (std::uint32_t k = node.begin; k < node.end; ++k) {
    const Disc& disc = discs_[order_[k]];
    if (isRemoved_[order_[k]] == 0) {
      node.maximumRank = std::max(node.maximumRank, static_cast<std::int64_t>(disc.rank));
      node.maximumRadius = std::max(node.maximumRadius, disc.radius);
    }
  }
}

void DiscTree::remove(std::size_t index) {
  isRemoved_[index] = 1;
  std::uint32_t node = leafOf_[index];
  update(nodes_[node]);
  while (node != 0) {
    node = nodes_[node].parent;
    update(nodes_[node]);
  }
}

}  // namespace espalier::environment

#include "environment/hydraulics/plant_trees.h"

#include <bit>
#include <cmath>

namespace espalier::environment {

namespace {

/// Mixes a number into a key (the finaliser of SplitMix64, Steele, Lea & Flood 2014).
std::uint64_t mixInto(std::uint64_t key, std::uint64_t number) {
  std::uint64_t z = key * 0x9e3779b97f4a7c15ULL + number + 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

PlantTrees::PlantTrees(const turtle::Geometry& geometry, double join) : join_(join) {
  const std::size_t count = geometry.segments.size();
  nodes_.reserve(count + 1);
  before_.reserve(count + 1);
  last_.reserve(count + 1);
  for (std::size_t i = 0; i < count; ++i) {
    if (geometry.start[i] == geometry.end[i]) {
      continue;
    }
    Node node{.parent = kNone,
              .place = geometry.start[i],
              .plant = geometry.segments.plant[i],
              .module = geometry.segments.module[i],
              .order = geometry.segments.branchOrder[i] + 1,
              .radius = 0.5 * geometry.endWidth[i]};
    std::uint32_t parent = find(node.plant, node.module, node.place);
    if (parent == kNone) {
      parent = static_cast<std::uint32_t>(nodes_.size());
      Node collar = node;
      collar.module = 0;
      add(collar);
    }
    node.parent = parent;
    node.place = geometry.end[i];
    add(node);
  }
}

std::optional<std::uint32_t> PlantTrees::nodeAt(std::uint32_t plant, std::uint64_t module,
                                                const core::Vec3& place) const {
  const std::uint32_t found = find(plant, module, place);
  return found == kNone ? std::nullopt : std::optional(found);
}

std::uint64_t PlantTrees::keyOf(std::uint32_t plant, const core::Vec3& place, int dx, int dy, int dz) const {
  const auto part = [this](double coordinate, int shift) {
    // + 0.0 makes −0 and 0 one key
    return std::bit_cast<std::uint64_t>(join_ > 0.0 ? std::floor(coordinate / join_) + shift + 0.0 : coordinate + 0.0);
  };
  return mixInto(mixInto(mixInto(plant, part(place.x, dx)), part(place.y, dy)), part(place.z, dz));
}

std::uint32_t PlantTrees::find(std::uint32_t plant, std::uint64_t module, const core::Vec3& place) const {
  const int reach = join_ > 0.0 ? 1 : 0;
  std::uint32_t best = kNone;
  double nearest = join_;
  for (int dx = -reach; dx <= reach; ++dx) {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dz = -reach; dz <= reach; ++dz) {
        const auto chain = last_.find(keyOf(plant, place, dx, dy, dz));
        for (std::uint32_t i = chain == last_.end() ? kNone : chain->second; i != kNone; i = before_[i]) {
          const Node& node = nodes_[i];
          const double distance = core::length(node.place - place);
          // of points at one distance the last
          const bool isNearer = distance < nearest || (distance == nearest && (best == kNone || i > best));
          if (node.plant == plant && node.module <= module && isNearer) {
            best = i;
            nearest = distance;
          }
        }
      }
    }
  }
  return best;
}

void PlantTrees::add(const Node& node) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  const auto [chain, isNew] = last_.try_emplace(keyOf(node.plant, node.place, 0, 0, 0), index);
  before_.push_back(isNew ? kNone : chain->second);
  chain->second = index;
  nodes_.push_back(node);
}

}  // namespace espalier::environment

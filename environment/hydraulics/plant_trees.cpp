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

void PlantTrees::update(const turtle::Geometry& geometry) {
  std::swap(nodes_, nodesBefore_);
  nodes_.clear();
  nodes_.reserve(geometry.segments.size() + 1);
  std::unordered_map<std::uint32_t, Plant> plantsBefore = std::move(plants_);
  plants_.clear();
  keptPlants_ = 0;
  const std::vector<std::uint32_t>& numbers = geometry.segments.plant;
  for (std::size_t first = 0, end = 0; first < numbers.size(); first = end) {
    end = first + 1;
    while (end < numbers.size() && numbers[end] == numbers[first]) {
      ++end;
    }
    Plant& plant = plants_[numbers[first]];
    const auto start = static_cast<std::uint32_t>(nodes_.size());
    const auto found = plantsBefore.find(numbers[first]);
    if (found != plantsBefore.end() && isKept(geometry, first, end, found->second)) {
      plant = std::move(found->second);
      for (std::uint32_t i = plant.first; i < plant.end; ++i) {
        nodes_.push_back(nodesBefore_[i]);
        std::uint32_t& parent = nodes_.back().parent;
        parent = parent == kNone ? kNone : parent - plant.first + start;
      }
      ++keptPlants_;
    } else {
      plant.first = start;
      join(geometry, first, end, plant);
    }
    plant.first = start;
    plant.end = static_cast<std::uint32_t>(nodes_.size());
  }
}

/// Whether a plant of the call before drew these segments.
bool PlantTrees::isKept(const turtle::Geometry& geometry, std::size_t first, std::size_t end,
                        const Plant& before) const {
  std::uint32_t node = before.first;
  for (std::size_t i = first; i < end; ++i) {
    if (geometry.start[i] == geometry.end[i]) {
      continue;
    }
    node += node < before.end && nodesBefore_[node].parent == kNone ? 1 : 0;
    if (node >= before.end) {
      return false;
    }
    const Node& old = nodesBefore_[node];
    if (!(old.start == geometry.start[i] && old.place == geometry.end[i] && old.module == geometry.segments.module[i] &&
          old.order == geometry.segments.branchOrder[i] + 1 && old.radius == 0.5 * geometry.endWidth[i])) {
      return false;
    }
    ++node;
  }
  return node == before.end;
}

/// Joins the segments of one plant to trees.
void PlantTrees::join(const turtle::Geometry& geometry, std::size_t first, std::size_t end, Plant& plant) {
  plant.before.reserve(end - first + 1);
  plant.last.reserve(end - first + 1);
  for (std::size_t i = first; i < end; ++i) {
    if (geometry.start[i] == geometry.end[i]) {
      continue;
    }
    Node node{.parent = kNone,
              .place = geometry.start[i],
              .start = geometry.start[i],
              .plant = geometry.segments.plant[i],
              .module = geometry.segments.module[i],
              .order = geometry.segments.branchOrder[i] + 1,
              .radius = 0.5 * geometry.endWidth[i]};
    std::uint32_t parent = find(plant, node.module, node.place);
    if (parent == kNone) {
      parent = static_cast<std::uint32_t>(nodes_.size());
      Node collar = node;
      collar.module = 0;
      add(collar, plant);
    }
    node.parent = parent;
    node.place = geometry.end[i];
    add(node, plant);
  }
}

std::optional<std::uint32_t> PlantTrees::nodeAt(std::uint32_t plant, std::uint64_t module,
                                                const core::Vec3& place) const {
  const auto drawn = plants_.find(plant);
  const std::uint32_t found = drawn == plants_.end() ? kNone : find(drawn->second, module, place);
  return found == kNone ? std::nullopt : std::optional(found);
}

std::uint64_t PlantTrees::keyOf(const core::Vec3& place, int dx, int dy, int dz) const {
  const auto part = [this](double coordinate, int shift) {
    // + 0.0 makes −0 and 0 one key
    return std::bit_cast<std::uint64_t>(join_ > 0.0 ? std::floor(coordinate / join_) + shift + 0.0 : coordinate + 0.0);
  };
  return mixInto(mixInto(mixInto(0, part(place.x, dx)), part(place.y, dy)), part(place.z, dz));
}

/// The index in `nodes_` of the node that nodeAt() finds, or kNone.
std::uint32_t PlantTrees::find(const Plant& plant, std::uint64_t module, const core::Vec3& place) const {
  const int reach = join_ > 0.0 ? 1 : 0;
  std::uint32_t best = kNone;
  double nearest = join_;
  for (int dx = -reach; dx <= reach; ++dx) {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dz = -reach; dz <= reach; ++dz) {
        const auto chain = plant.last.find(keyOf(place, dx, dy, dz));
        for (std::uint32_t i = chain == plant.last.end() ? kNone : chain->second; i != kNone; i = plant.before[i]) {
          const Node& node = nodes_[plant.first + i];
          const double distance = core::length(node.place - place);
          // of points at one distance the last
          const bool isNearer =
              distance < nearest || (distance == nearest && (best == kNone || plant.first + i > best));
          if (node.module <= module && isNearer) {
            best = plant.first + i;
            nearest = distance;
          }
        }
      }
    }
  }
  return best;
}

void PlantTrees::add(const Node& node, Plant& plant) {
  const auto index = static_cast<std::uint32_t>(nodes_.size()) - plant.first;
  const auto [chain, isNew] = plant.last.try_emplace(keyOf(node.place, 0, 0, 0), index);
  plant.before.push_back(isNew ? kNone : chain->second);
  chain->second = index;
  nodes_.push_back(node);
}

}  // namespace espalier::environment

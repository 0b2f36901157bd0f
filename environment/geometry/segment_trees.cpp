#include "environment/geometry/segment_trees.h"

#include <utility>

namespace espalier::environment {

void SegmentTrees::clear() {
  segments_.clear();
  parts_.clear();
}

BoxTree SegmentTrees::treeOf(std::size_t begin, std::size_t end) const {
  std::vector<Bounds> boxes;
  boxes.reserve(end - begin);
  for (std::size_t k = begin; k < end; ++k) {
    boxes.push_back(boundsOf(segments_[k].capsule));
  }
  return BoxTree(boxes);
}

std::optional<std::uint32_t> SegmentTrees::plantOf(std::size_t begin, std::size_t end) const {
  const std::uint32_t plant = segments_[begin].plant;
  for (std::size_t k = begin; k < end; ++k) {
    if (segments_[k].plant != plant) {
      return std::nullopt;
    }
  }
  return plant;
}

void SegmentTrees::add(std::span<const PlantSegment> segments) {
  if (segments.empty()) {
    return;
  }
  const std::size_t before = segments_.size();
  std::size_t begin = before;
  parts_.reserve(parts_.size() + 1);
  segments_.insert(segments_.end(), segments.begin(), segments.end());
  const std::size_t end = segments_.size();
  // parts that are not much larger than what comes after them are taken into it
  std::size_t kept = parts_.size();
  while (kept > 0 && parts_[kept - 1].end - parts_[kept - 1].begin <= 2 * (end - begin)) {
    begin = parts_[--kept].begin;
  }
  try {
    Part part{begin, end, plantOf(begin, end), treeOf(begin, end)};
    parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(kept), parts_.end());
    parts_.push_back(std::move(part));
  } catch (...) {
    // out of memory: as before
    segments_.resize(before);
    throw;
  }
}

bool SegmentTrees::isClear(std::uint32_t plant, const Capsule& segment) const {
  const core::Vec3 middle = (segment.a + segment.b) * 0.5;
  const double around = core::length(segment.b - segment.a) * 0.5 + segment.radius;
  for (const Part& part : parts_) {
    if (part.plant == plant) {
      continue;  // a dense plant would visit all of its own
    }
    bool isClear = true;
    part.tree.visitNear(middle, around, [&](std::size_t index) {
      const auto& [owner, other] = segments_[part.begin + index];
      isClear = isClear && (owner == plant ||
                            segmentDistance(segment.a, segment.b, other.a, other.b) > segment.radius + other.radius);
      return isClear ? around : 0.0;
    });
    if (!isClear) {
      return false;
    }
  }
  return true;
}

}  // namespace espalier::environment

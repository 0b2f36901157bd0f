#include "engine/turtle/export/tubes.h"

#include <algorithm>
#include <cmath>

#include "engine/turtle/turtle_motion.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

Vec3 directionOf(const Segment& segment) {
  const Vec3 d = segment.end - segment.start;
  return core::length(d) > 0.0 ? core::normalised(d) : segment.frame.heading;
}

Vec3 normalPart(const Vec3& v, const Vec3& axis) {
  const Vec3 part = v - core::dot(v, axis) * axis;
  if (core::length(part) > 1e-9) {
    return core::normalised(part);
  }
  const Vec3 other = std::abs(axis.x) < 0.9 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  return core::normalised(other - core::dot(other, axis) * axis);
}

}  // namespace

std::vector<SegmentChain> chainsOf(const Scene& scene, const std::vector<std::int32_t>& materials) {
  std::vector<SegmentChain> chains;
  std::vector<std::uint32_t> chainOf(scene.segments.size(), kNoParent);
  std::vector<bool> isContinued(scene.segments.size(), false);
  for (std::uint32_t i = 0; i < scene.segments.size(); ++i) {
    const Segment& segment = scene.segments[i];
    const std::uint32_t parent = segment.parent;
    // a segment that turns back on its parent cannot share a ring with it
    const bool joins = parent < i && !isContinued[parent] && scene.segments[parent].end == segment.start &&
                       scene.segments[parent].branchOrder == segment.branchOrder &&
                       scene.segments[parent].plant == segment.plant && materials[parent] == materials[i] &&
                       core::dot(directionOf(scene.segments[parent]), directionOf(segment)) > -0.7;
    if (joins) {
      isContinued[parent] = true;
      chainOf[i] = chainOf[parent];
      chains[chainOf[i]].push_back(i);
    } else {
      chainOf[i] = static_cast<std::uint32_t>(chains.size());
      chains.push_back({i});
    }
  }
  return chains;
}

std::vector<TubeRing> ringsOf(const Scene& scene, const SegmentChain& chain, double unit) {
  std::vector<TubeRing> rings;
  Vec3 previousTangent;
  Vec3 up;
  double along = 0.0;
  for (std::size_t k = 0; k <= chain.size(); ++k) {
    const bool isFirst = k == 0;
    const bool isLast = k == chain.size();
    const Segment& segment = scene.segments[chain[isLast ? k - 1 : k]];
    // between two segments the ring lies in the plane that halves their angle
    Vec3 tangent = directionOf(segment);
    if (!isFirst && !isLast) {
      tangent = core::normalised(tangent + directionOf(scene.segments[chain[k - 1]]));
    }
    up = normalPart(isFirst ? segment.frame.up : transported(up, previousTangent, tangent), tangent);
    previousTangent = tangent;
    if (!isFirst) {
      const Segment& before = scene.segments[chain[k - 1]];
      along += core::length(before.end - before.start);
    }
    rings.push_back({.centre = isLast ? segment.end : segment.start,
                     .up = up,
                     .side = core::cross(tangent, up),
                     .radius = 0.5 * unit * (isLast ? segment.endWidth : segment.startWidth),
                     .along = along});
  }
  return rings;
}

}  // namespace espalier::turtle

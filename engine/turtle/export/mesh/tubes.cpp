#include "engine/turtle/export/mesh/tubes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/turtle/turtle_motion.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr double kSharpestMitre = 0.5;      // cosine of the bend up to which one oblique ring serves
constexpr double kSharpestJoint = -0.94;    // cosine of the bend from which a segment turns back and begins a new tube
constexpr double kElbowStepRadians = 0.53;  // between the rings of an elbow, at most

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

/// Makes the rings of one chain from its base outward.
class RingBuilder {
 public:
  RingBuilder(const Scene& scene, const LineLook& look) : scene_(scene), look_(look) {}

  void begin(std::uint32_t segment);
  void beginAfter(std::uint32_t before, std::uint32_t segment, const SegmentChains::Continuation& continuation);
  void joint(std::uint32_t before, std::uint32_t after);
  void end(std::uint32_t segment);
  void endBefore(std::uint32_t segment, std::uint32_t after);
  [[nodiscard]] SegmentChains::Continuation continuation() const { return {up_, along_, turns_}; }
  [[nodiscard]] std::vector<TubeRing> take() { return std::move(rings_); }
  void dropRings() { rings_.clear(); }

 private:
  void turnTo(const Vec3& tangent);
  void pass(std::uint32_t segment);
  void addCollar(std::uint32_t segment, double radius);
  void addRing(const Vec3& centre, double radius, double slope, std::uint32_t segment);
  void addMitre(const Vec3& centre, const Vec3& before, const Vec3& after, double radius, double slope,
                std::uint32_t segment);
  [[nodiscard]] double slopeOf(std::uint32_t segment) const;
  [[nodiscard]] double startRadius(std::uint32_t segment) const {
    return 0.5 * look_.startWidth(scene_.segments[segment]);
  }
  [[nodiscard]] double endRadius(std::uint32_t segment) const { return 0.5 * look_.endWidth(scene_.segments[segment]); }

  const Scene& scene_;
  LineLook look_;
  std::vector<TubeRing> rings_;
  Vec3 tangent_;  // of the frame that is carried along
  Vec3 up_;
  double along_ = 0.0;
  double turns_ = 0.0;
};

double RingBuilder::slopeOf(std::uint32_t segment) const {
  const double length = core::length(scene_.segments[segment].end - scene_.segments[segment].start);
  return length > 0.0 ? (startRadius(segment) - endRadius(segment)) / length : 0.0;
}

// turns the frame by the shortest way: exact parallel transport along straight pieces
void RingBuilder::turnTo(const Vec3& tangent) {
  up_ = normalPart(transported(up_, tangent_, tangent), tangent);
  tangent_ = tangent;
}

// goes along a segment to its end
void RingBuilder::pass(std::uint32_t segment) {
  const double length = core::length(scene_.segments[segment].end - scene_.segments[segment].start);
  const double circumference = std::numbers::pi * (startRadius(segment) + endRadius(segment));
  along_ += length;
  turns_ += circumference > 0.0 ? length / circumference : 0.0;
}

// a fork's limb takes its own width over a short way, instead of at the joint
void RingBuilder::addCollar(std::uint32_t segment, double radius) {
  const Segment& limb = scene_.segments[segment];
  const double length = core::length(limb.end - limb.start);
  const double way = std::min(0.5 * length, kCollarRadii * std::max(radius, startRadius(segment)));
  if (!(way > 0.0)) {
    return;
  }
  const double share = way / length;
  const double own = startRadius(segment) + share * (endRadius(segment) - startRadius(segment));
  const double circumference = std::numbers::pi * (radius + own);
  const double along = along_;
  const double turns = turns_;
  along_ += way;
  turns_ += circumference > 0.0 ? way / circumference : 0.0;
  addRing(limb.start + way * tangent_, own, slopeOf(segment), segment);
  // the whole segment is passed at its end
  along_ = along;
  turns_ = turns;
}

void RingBuilder::addRing(const Vec3& centre, double radius, double slope, std::uint32_t segment) {
  const Vec3 side = core::cross(tangent_, up_);
  rings_.push_back({.centre = centre,
                    .up = radius * up_,
                    .side = radius * side,
                    .normalUp = up_,
                    .normalSide = side,
                    .slope = slope,
                    .along = along_,
                    .turns = turns_,
                    .segment = segment});
}

// the section of both tubes by the plane that halves their angle: neither gets thinner toward it
void RingBuilder::addMitre(const Vec3& centre, const Vec3& before, const Vec3& after, double radius, double slope,
                           std::uint32_t segment) {
  const Vec3 up = up_;
  const Vec3 side = core::cross(before, up);
  const Vec3 middle = core::normalised(before + after);
  const double cosine = core::dot(before, middle);
  const auto projected = [&](const Vec3& v) { return v - (core::dot(v, middle) / cosine) * before; };
  turnTo(middle);
  addRing(centre, radius, slope, segment);
  rings_.back().up = radius * projected(up);
  rings_.back().side = radius * projected(side);
}

void RingBuilder::begin(std::uint32_t segment) {
  const Segment& first = scene_.segments[segment];
  const Vec3 direction = directionOf(first);
  if (first.parent < segment && scene_.segments[first.parent].end == first.start) {
    const Vec3 before = directionOf(scene_.segments[first.parent]);
    if (core::dot(before, direction) >= kSharpestMitre) {
      tangent_ = direction;
      up_ = normalPart(first.frame.up, direction);
      turnTo(before);
      addMitre(first.start, before, direction, startRadius(segment), slopeOf(segment), segment);
      turnTo(direction);
      return;
    }
  }
  tangent_ = direction;
  up_ = normalPart(first.frame.up, direction);
  addRing(first.start, startRadius(segment), slopeOf(segment), segment);
}

void RingBuilder::beginAfter(std::uint32_t before, std::uint32_t segment,
                             const SegmentChains::Continuation& continuation) {
  tangent_ = directionOf(scene_.segments[before]);
  up_ = continuation.up;
  along_ = continuation.along;
  turns_ = continuation.turns;
  joint(before, segment);
  for (TubeRing& ring : rings_) {
    ring.segment = segment;
  }
}

// the chain of the next segment's material makes the rest of the joint
void RingBuilder::endBefore(std::uint32_t segment, std::uint32_t after) {
  const std::size_t count = rings_.size();
  joint(segment, after);
  rings_.resize(count + 1);
}

void RingBuilder::end(std::uint32_t segment) {
  const Segment& last = scene_.segments[segment];
  pass(segment);
  addRing(last.end, endRadius(segment), slopeOf(segment), segment);
}

void RingBuilder::joint(std::uint32_t before, std::uint32_t after) {
  const Segment& first = scene_.segments[before];
  const Vec3 from = directionOf(first);
  const Vec3 to = directionOf(scene_.segments[after]);
  const double cosine = std::clamp(core::dot(from, to), -1.0, 1.0);
  pass(before);
  const double radius = endRadius(before);
  const double next = startRadius(after);
  const bool isFork = first.branchOrder != scene_.segments[after].branchOrder;
  const bool hasStep = radius != next && !isFork;
  if (cosine >= kSharpestMitre) {
    const double slope = hasStep ? slopeOf(before) : 0.5 * (slopeOf(before) + slopeOf(after));
    if (hasStep) {
      const Vec3 up = up_;
      addMitre(first.end, from, to, radius, slope, before);
      // a second ring of the next width at the same place
      tangent_ = from;
      up_ = up;
      addMitre(first.end, from, to, next, slopeOf(after), after);
    } else {
      addMitre(first.end, from, to, radius, slope, before);
    }
  } else {
    // an elbow: rings about the joint, from one direction to the other
    const double angle = core::acos(cosine);
    const int steps = static_cast<int>(std::ceil(angle / kElbowStepRadians));
    const Vec3 axis = core::normalised(core::cross(from, to));
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      turnTo(i == steps ? to : rotatedAbout(from, axis, t * angle));
      addRing(first.end, radius + t * (next - radius), i == 0 ? slopeOf(before) : slopeOf(after),
              i == 0 ? before : after);
    }
  }
  turnTo(to);
  if (isFork && cosine >= kSharpestMitre && radius != next) {
    addCollar(after, radius);
  }
}

bool looksAlike(const Palette& palette, const Segment& a, const Segment& b) {
  return palette.materialOf(a) == palette.materialOf(b) && a.texture == b.texture;
}

// of the limbs of a fork without a continuing axis the thickest, of equal ones the straightest, goes on with the tube
void continueForks(const std::vector<Segment>& segments, double sharpestJoint, std::vector<std::uint32_t>& next) {
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    const Segment& limb = segments[i];
    if (limb.parent >= i) {
      continue;
    }
    const Segment& before = segments[limb.parent];
    const double cosine = core::dot(directionOf(before), directionOf(limb));
    if (before.branchOrder >= limb.branchOrder || !(before.end == limb.start) || before.plant != limb.plant ||
        cosine <= sharpestJoint) {
      continue;
    }
    std::uint32_t& chosen = next[limb.parent];
    if (chosen == kNoParent) {
      chosen = i;
      continue;
    }
    const Segment& other = segments[chosen];
    const double otherCosine = core::dot(directionOf(before), directionOf(other));
    if (other.branchOrder > before.branchOrder &&
        std::pair(limb.startWidth, cosine) > std::pair(other.startWidth, otherCosine)) {
      chosen = i;
    }
  }
}

}  // namespace

std::vector<std::uint32_t> continuationsOf(const Scene& scene, double sharpestJoint) {
  const std::vector<Segment>& segments = scene.segments;
  std::vector<std::uint32_t> next(segments.size(), kNoParent);
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    const Segment& segment = segments[i];
    if (segment.parent >= i || next[segment.parent] != kNoParent) {
      continue;
    }
    const Segment& before = segments[segment.parent];
    if (before.end == segment.start && before.branchOrder == segment.branchOrder && before.plant == segment.plant &&
        core::dot(directionOf(before), directionOf(segment)) > sharpestJoint) {
      next[segment.parent] = i;
    }
  }
  continueForks(segments, sharpestJoint, next);
  return next;
}

SegmentChains chainsOf(const Scene& scene, const Palette& palette) {
  SegmentChains chains;
  const std::vector<Segment>& segments = scene.segments;
  chains.next = continuationsOf(scene, kSharpestJoint);
  bool hasSeveralLooks = false;
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    const std::uint32_t parent = segments[i].parent;
    const bool joins = parent < i && chains.next[parent] == i;
    if (!joins || !looksAlike(palette, segments[parent], segments[i])) {
      hasSeveralLooks = hasSeveralLooks || joins;
      chains.heads.push_back(i);
    }
  }
  if (!hasSeveralLooks) {
    return chains;
  }
  // carry the frame along each axis to where its look changes
  std::vector<bool> isContinued(segments.size(), false);
  for (const std::uint32_t next : chains.next) {
    if (next != kNoParent) {
      isContinued[next] = true;
    }
  }
  for (const std::uint32_t head : chains.heads) {
    if (isContinued[head]) {
      continue;
    }
    RingBuilder builder(scene, {});
    builder.begin(head);
    for (std::uint32_t at = head, next = chains.next[at]; next != kNoParent; at = next, next = chains.next[at]) {
      if (!looksAlike(palette, segments[at], segments[next])) {
        chains.continuations.emplace(next, builder.continuation());
      }
      builder.joint(at, next);
      builder.dropRings();
    }
  }
  return chains;
}

std::vector<TubeRing> ringsOf(const Scene& scene, const Palette& palette, const SegmentChains& chains,
                              std::uint32_t head, const LineLook& look) {
  RingBuilder builder(scene, look);
  if (const auto found = chains.continuations.find(head); found != chains.continuations.end()) {
    builder.beginAfter(scene.segments[head].parent, head, found->second);
  } else {
    builder.begin(head);
  }
  for (std::uint32_t at = head;; at = chains.next[at]) {
    const std::uint32_t next = chains.next[at];
    if (next == kNoParent) {
      builder.end(at);
      break;
    }
    if (!looksAlike(palette, scene.segments[at], scene.segments[next])) {
      builder.endBefore(at, next);
      break;
    }
    builder.joint(at, next);
  }
  return builder.take();
}

}  // namespace espalier::turtle

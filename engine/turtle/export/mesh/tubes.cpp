#include "engine/turtle/export/mesh/tubes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/turtle/turtle_motion.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr double kSharpestMitre = 0.5;      // cosine of the bend up to which one oblique ring serves
constexpr double kSharpestJoint = -0.94;    // cosine of the bend from which a segment turns back and begins a new tube
constexpr double kElbowStepRadians = 0.53;  // between the rings of an elbow, at most
constexpr std::size_t kCommonRings = 16;    // few chains have more
constexpr std::size_t kNumbersInTask = 256;

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

/// A segment as a piece of a tube.
struct Limb {
  std::uint32_t index = 0;  // into Scene::segments
  Vec3 start, end;
  Vec3 direction;
  double length = 0.0;
  double startRadius = 0.0, endRadius = 0.0;
  double slope = 0.0;  // radius lost per unit of length
  std::uint32_t branchOrder = 0;
};

/// Makes the rings of one chain from its base outward.
class RingBuilder {
 public:
  RingBuilder(const Scene& scene, const LineLook& look) : scene_(scene), look_(look) {}

  [[nodiscard]] Limb limbOf(std::uint32_t segment) const;
  void begin(const Limb& limb);
  void beginAfter(std::uint32_t before, const Limb& limb, const SegmentChains::Continuation& continuation);
  void joint(const Limb& before, const Limb& after);
  void end(const Limb& limb);
  void endBefore(const Limb& limb, const Limb& after);
  [[nodiscard]] SegmentChains::Continuation continuation() const { return {up_, along_, turns_}; }
  [[nodiscard]] std::vector<TubeRing> take() { return std::move(rings_); }
  void reserve(std::size_t rings) { rings_.reserve(rings); }
  void dropRings() { rings_.clear(); }

 private:
  void turnTo(const Vec3& tangent);
  void pass(const Limb& limb);
  void addCollar(const Limb& limb, double radius);
  void addRing(const Vec3& centre, double radius, double slope, std::uint32_t segment);
  void addMitre(const Vec3& centre, const Vec3& before, const Vec3& after, double radius, double slope,
                std::uint32_t segment);

  const Scene& scene_;
  LineLook look_;
  std::vector<TubeRing> rings_;
  Vec3 tangent_;  // of the frame that is carried along
  Vec3 up_;
  double along_ = 0.0;
  double turns_ = 0.0;
};

Limb RingBuilder::limbOf(std::uint32_t segment) const {
  const Segment& of = scene_.segments[segment];
  const Vec3 course = of.end - of.start;
  Limb limb{.index = segment,
            .start = of.start,
            .end = of.end,
            .direction = course,
            .length = core::length(course),
            .startRadius = 0.5 * look_.startWidth(of),
            .endRadius = 0.5 * look_.endWidth(of),
            .branchOrder = of.branchOrder};
  if (limb.length > 0.0) {
    limb.direction = {course.x / limb.length, course.y / limb.length, course.z / limb.length};
    limb.slope = (limb.startRadius - limb.endRadius) / limb.length;
  } else {
    limb.direction = of.frame.heading;
  }
  return limb;
}

// turns the frame by the shortest way: exact parallel transport along straight pieces
void RingBuilder::turnTo(const Vec3& tangent) {
  up_ = normalPart(transported(up_, tangent_, tangent), tangent);
  tangent_ = tangent;
}

// goes along a limb to its end
void RingBuilder::pass(const Limb& limb) {
  const double circumference = std::numbers::pi * (limb.startRadius + limb.endRadius);
  along_ += limb.length;
  turns_ += circumference > 0.0 ? limb.length / circumference : 0.0;
}

// a fork's limb takes its own width over a short way, instead of at the joint
void RingBuilder::addCollar(const Limb& limb, double radius) {
  const double way = std::min(0.5 * limb.length, kCollarRadii * std::max(radius, limb.startRadius));
  if (!(way > 0.0)) {
    return;
  }
  const double share = way / limb.length;
  const double own = limb.startRadius + share * (limb.endRadius - limb.startRadius);
  const double circumference = std::numbers::pi * (radius + own);
  const double along = along_;
  const double turns = turns_;
  along_ += way;
  turns_ += circumference > 0.0 ? way / circumference : 0.0;
  addRing(limb.start + way * tangent_, own, limb.slope, limb.index);
  // the whole limb is passed at its end
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

void RingBuilder::begin(const Limb& limb) {
  const Segment& first = scene_.segments[limb.index];
  tangent_ = limb.direction;
  up_ = normalPart(first.frame.up, limb.direction);
  if (first.parent < limb.index && scene_.segments[first.parent].end == limb.start) {
    const Vec3 before = directionOf(scene_.segments[first.parent]);
    if (core::dot(before, limb.direction) >= kSharpestMitre) {
      turnTo(before);
      addMitre(limb.start, before, limb.direction, limb.startRadius, limb.slope, limb.index);
      turnTo(limb.direction);
      return;
    }
  }
  addRing(limb.start, limb.startRadius, limb.slope, limb.index);
}

void RingBuilder::beginAfter(std::uint32_t before, const Limb& limb, const SegmentChains::Continuation& continuation) {
  const Limb last = limbOf(before);
  tangent_ = last.direction;
  up_ = continuation.up;
  along_ = continuation.along;
  turns_ = continuation.turns;
  joint(last, limb);
  for (TubeRing& ring : rings_) {
    ring.segment = limb.index;
  }
}

// the chain of the next limb's material makes the rest of the joint
void RingBuilder::endBefore(const Limb& limb, const Limb& after) {
  const std::size_t count = rings_.size();
  joint(limb, after);
  rings_.resize(count + 1);
}

void RingBuilder::end(const Limb& limb) {
  pass(limb);
  addRing(limb.end, limb.endRadius, limb.slope, limb.index);
}

void RingBuilder::joint(const Limb& before, const Limb& after) {
  const Vec3& from = before.direction;
  const Vec3& to = after.direction;
  const double cosine = std::clamp(core::dot(from, to), -1.0, 1.0);
  pass(before);
  const double radius = before.endRadius;
  const double next = after.startRadius;
  const bool isFork = before.branchOrder != after.branchOrder;
  const bool hasStep = radius != next && !isFork;
  if (cosine >= kSharpestMitre) {
    const double slope = hasStep ? before.slope : 0.5 * (before.slope + after.slope);
    const Vec3 up = up_;
    addMitre(before.end, from, to, radius, slope, before.index);
    if (hasStep) {
      // a second ring of the next width at the same place
      tangent_ = from;
      up_ = up;
      addMitre(before.end, from, to, next, after.slope, after.index);
    }
  } else {
    // an elbow: rings about the joint, from one direction to the other
    const double angle = core::acos(cosine);
    const int steps = static_cast<int>(std::ceil(angle / kElbowStepRadians));
    const Vec3 axis = core::normalised(core::cross(from, to));
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      turnTo(i == steps ? to : rotatedAbout(from, axis, t * angle));
      addRing(before.end, radius + t * (next - radius), i == 0 ? before.slope : after.slope,
              i == 0 ? before.index : after.index);
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

/// How a line goes on from the one that it grows on.
struct Joint {
  enum class Kind : std::uint8_t { None, Axis, Fork };  // Fork: it is a side branch of the other
  double cosine = 0.0;                                  // of the bend
  std::uint32_t parent = kNoParent;
  Kind kind = Kind::None;
};

Joint jointOf(std::span<const Segment> segments, std::uint32_t index, double sharpestJoint) {
  const Segment& limb = segments[index];
  if (limb.parent >= index) {
    return {};
  }
  const Segment& before = segments[limb.parent];
  if (before.branchOrder > limb.branchOrder || before.plant != limb.plant || !(before.end == limb.start)) {
    return {};
  }
  const double cosine = core::dot(directionOf(before), directionOf(limb));
  if (!(cosine > sharpestJoint)) {
    return {};
  }
  return {cosine, limb.parent, before.branchOrder == limb.branchOrder ? Joint::Kind::Axis : Joint::Kind::Fork};
}

// runs `task` for each number below `count`, on all threads
void forNumbers(core::WorkerTeam& team, std::size_t count, const std::function<void(std::uint32_t)>& task) {
  const std::size_t blocks = (count + kNumbersInTask - 1) / kNumbersInTask;
  team.forEach(blocks, [&](std::size_t block) {
    const std::size_t end = std::min(count, (block + 1) * kNumbersInTask);
    for (std::size_t i = block * kNumbersInTask; i < end; ++i) {
      task(static_cast<std::uint32_t>(i));
    }
  });
}

// begins the tube of a chain; whether it is open there
bool beginChain(const Scene& scene, const SegmentChains& chains, const Limb& limb, RingBuilder& builder) {
  const std::uint32_t place = chains.continuationOf[limb.index];
  if (place == SegmentChains::kNoContinuation) {
    builder.begin(limb);
    return false;
  }
  const SegmentChains::Continuation& continuation = chains.continuations[place];
  builder.beginAfter(scene.segments[limb.index].parent, limb, continuation);
  return continuation.isOpen;
}

// carries the frame along the tube that begins with a chain, up to the last of the chains that go on with it
void carryAlong(const Scene& scene, SegmentChains& chains, const LineLook& look, std::uint32_t head) {
  std::uint32_t last = kNoParent;
  for (std::uint32_t i = chains.next[head]; i != kNoParent; i = chains.next[i]) {
    last = chains.continuationOf[i] != SegmentChains::kNoContinuation ? i : last;
  }
  if (last == kNoParent) {
    return;
  }
  RingBuilder builder(scene, look);
  Limb limb = builder.limbOf(head);
  builder.begin(limb);
  while (limb.index != last) {
    const Limb after = builder.limbOf(chains.next[limb.index]);
    if (const std::uint32_t place = chains.continuationOf[after.index]; place != SegmentChains::kNoContinuation) {
      const bool isOpen = chains.continuations[place].isOpen;
      chains.continuations[place] = builder.continuation();
      chains.continuations[place].isOpen = isOpen;
    }
    builder.joint(limb, after);
    builder.dropRings();
    limb = after;
  }
}

}  // namespace

std::vector<std::uint32_t> continuationsOf(const Scene& scene, double sharpestJoint, core::WorkerTeam& team) {
  const std::span<const Segment> segments = scene.segments.view();
  std::vector<Joint> joints(segments.size());
  forNumbers(team, segments.size(), [&](std::uint32_t i) { joints[i] = jointOf(segments, i, sharpestJoint); });
  std::vector<std::uint32_t> next(segments.size(), kNoParent);
  for (std::uint32_t i = 0; i < joints.size(); ++i) {
    if (joints[i].kind == Joint::Kind::Axis && next[joints[i].parent] == kNoParent) {
      next[joints[i].parent] = i;
    }
  }
  // of the limbs of a fork without a continuing axis the thickest, of equal ones the straightest, goes on with the tube
  for (std::uint32_t i = 0; i < joints.size(); ++i) {
    if (joints[i].kind != Joint::Kind::Fork) {
      continue;
    }
    std::uint32_t& chosen = next[joints[i].parent];
    const bool continuesAxis = chosen != kNoParent && joints[chosen].kind == Joint::Kind::Axis;
    if (chosen == kNoParent || (!continuesAxis && std::pair(segments[i].startWidth, joints[i].cosine) >
                                                      std::pair(segments[chosen].startWidth, joints[chosen].cosine))) {
      chosen = i;
    }
  }
  return next;
}

SegmentChains chainsOf(const Scene& scene, const Palette& palette, const LineLook& look, core::WorkerTeam& team) {
  SegmentChains chains;
  const std::span<const Segment> segments = scene.segments.view();
  chains.next = continuationsOf(scene, kSharpestJoint, team);
  const auto joins = [&](std::uint32_t i) { return segments[i].parent < i && chains.next[segments[i].parent] == i; };
  std::vector<std::uint8_t> isAlike(segments.size());  // each one and the one that it goes on from
  forNumbers(team, segments.size(), [&](std::uint32_t i) {
    isAlike[i] = joins(i) && looksAlike(palette, segments[segments[i].parent], segments[i]) ? 1 : 0;
  });
  std::vector<std::uint32_t> places(segments.size(), 0);  // of each segment in its chain
  chains.continuationOf.assign(segments.size(), SegmentChains::kNoContinuation);
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    if (isAlike[i] != 0 && places[segments[i].parent] + 1 < kLongestChain) {
      places[i] = places[segments[i].parent] + 1;
      continue;
    }
    chains.heads.push_back(i);
    if (joins(i)) {
      chains.continuationOf[i] = static_cast<std::uint32_t>(chains.continuations.size());
      chains.continuations.emplace_back().isOpen = isAlike[i] != 0;
    }
  }
  forNumbers(team, chains.heads.size(), [&](std::uint32_t i) {
    if (chains.continuationOf[chains.heads[i]] == SegmentChains::kNoContinuation) {
      carryAlong(scene, chains, look, chains.heads[i]);
    }
  });
  return chains;
}

Tube tubeOf(const Scene& scene, const Palette& palette, const SegmentChains& chains, std::uint32_t head,
            const LineLook& look) {
  RingBuilder builder(scene, look);
  builder.reserve(kCommonRings);
  Limb limb = builder.limbOf(head);
  Tube tube;
  tube.isOpenAtStart = beginChain(scene, chains, limb, builder);
  for (std::uint32_t place = 0;; ++place) {
    const std::uint32_t next = chains.next[limb.index];
    if (next == kNoParent) {
      builder.end(limb);
      break;
    }
    const Limb after = builder.limbOf(next);
    const bool isAlike = looksAlike(palette, scene.segments[limb.index], scene.segments[next]);
    if (!isAlike || place + 1 == kLongestChain) {
      tube.isOpenAtEnd = isAlike;
      builder.endBefore(limb, after);
      break;
    }
    builder.joint(limb, after);
    limb = after;
  }
  tube.rings = builder.take();
  return tube;
}

}  // namespace espalier::turtle

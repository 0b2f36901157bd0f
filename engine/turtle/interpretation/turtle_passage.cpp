#include "engine/turtle/interpretation/turtle_passage.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace espalier::turtle {
namespace {

template <typename T>
bool haveSameBytes(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

bool haveSameBits(const core::Frame& a, const core::Frame& b) {
  return haveSameBytes(a.heading, b.heading) && haveSameBytes(a.left, b.left) && haveSameBytes(a.up, b.up);
}

/// Whether a turtle does the same as another. Records only name parents: it matters whether there is one.
bool isSame(const TurtleState& a, const TurtleState& b) {
  const auto numbersOf = [](const TurtleState& s) {
    return std::array{s.width,        s.scale,      s.angleFactor,        s.oldElasticity,
                      s.startTangent, s.endTangent, s.startRadiusTangent, s.endRadiusTangent};
  };
  const auto countsOf = [](const TurtleState& s) {
    return std::array<std::uint32_t, 9>{s.branchOrder,
                                        static_cast<std::uint32_t>(s.colour),
                                        static_cast<std::uint32_t>(s.backColour),
                                        static_cast<std::uint32_t>(s.contour),
                                        static_cast<std::uint32_t>(s.contourSides),
                                        static_cast<std::uint32_t>(s.texture),
                                        s.cylinder,
                                        s.cylinderOrder,
                                        s.segment};
  };
  return haveSameBytes(a.position, b.position) && haveSameBits(a.frame, b.frame) &&
         haveSameBits(a.otherFrame, b.otherFrame) && haveSameBytes(a.previousHeading, b.previousHeading) &&
         haveSameBytes(a.previousUp, b.previousUp) && haveSameBytes(a.elasticity, b.elasticity) &&
         haveSameBytes(numbersOf(a), numbersOf(b)) && countsOf(a) == countsOf(b) &&
         a.hasSmoothRadius == b.hasSmoothRadius && (a.record == kNoParent) == (b.record == kNoParent);
}

}  // namespace

bool TurtlePassage::isSameFor(const TurtleState& turtle, std::span<const TurtleState> openBranches,
                              std::uint64_t modulesLeft) const {
  return (!endsString || modules == modulesLeft) && isSame(entry, turtle) && closesSame(0, openBranches);
}

bool TurtlePassage::closesSame(std::size_t first, std::span<const TurtleState> openBranches) const {
  return openBranches.size() + first >= closed.size() &&
         std::equal(closed.begin() + static_cast<std::ptrdiff_t>(first), closed.end(), openBranches.rbegin(), isSame);
}

}  // namespace espalier::turtle

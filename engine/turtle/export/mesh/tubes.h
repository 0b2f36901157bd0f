#pragma once

#include <cstdint>
#include <vector>

#include "engine/core/worker_team.h"
#include "engine/turtle/export/line_look.h"
#include "engine/turtle/export/mesh/mesh.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// The segments of a chain, at most: the mesh of a long line is made in pieces, by several threads and in little
/// memory.
inline constexpr std::uint32_t kLongestChain = 64;

/// The lines of a scene as chains: segments of one colour and texture that continue each other, from the base outward:
/// on one axis, or where an axis ends in a fork from it into one of its limbs.
struct SegmentChains {
  std::vector<std::uint32_t> heads;  // first segment of each chain, an index into Scene::segments (chainCount)
  std::vector<std::uint32_t> next;   // the segment that continues each one; kNoParent: none (segmentCount)

  /// Where a chain goes on from another one of the same tube: one of another colour or texture, or of full length.
  struct Continuation {
    core::Vec3 up;        // carried along the axis, normal to the segment before
    double along = 0.0;   // length of the tube up to the segment before
    double turns = 0.0;   // the same in circumferences
    bool isOpen = false;  // looks the same before and behind: no flat ends between them
  };
  static constexpr std::uint32_t kNoContinuation = 0xFFFFFFFF;
  std::vector<Continuation> continuations;
  std::vector<std::uint32_t> continuationOf;  // of a head, in `continuations`; kNoContinuation: none (segmentCount)
};

/// The segment that goes on with the tube of each segment (segmentCount); kNoParent: none. It begins where the other
/// ends, has the same branch order, bends by less than the angle with cosine `sharpestJoint`, and no earlier one does.
/// Where there is none, it is the thickest of the side branches that begin there, of equal ones the one that bends
/// least, so that a fork has no flat end. O(segments).
[[nodiscard]] std::vector<std::uint32_t> continuationsOf(const Scene& scene, double sharpestJoint,
                                                         core::WorkerTeam& team);

/// The length over which the tube of a fork takes the width of the limb that goes on with it, in the larger of the two
/// radii; at most half the limb.
inline constexpr double kCollarRadii = 2.0;

/// Splits the lines of a scene into chains along continuationsOf, whatever the bend but back. O(segments).
[[nodiscard]] SegmentChains chainsOf(const Scene& scene, const Palette& palette, const LineLook& look,
                                     core::WorkerTeam& team);

/// The tube of the chain that begins with segment `head`, turned with the least twist from ring to ring
/// (along straight pieces the discrete rotation-minimising frame is parallel transport). At a bend of up to 60 degrees
/// there is one oblique ring, the section of both pieces, so that neither gets thinner; sharper ones are elbows of
/// several rings. At a fork the tube takes the limb's width over a short way. A branch that begins a tube does so in
/// the plane between its parent and itself. Widths are those of `look`.
[[nodiscard]] Tube tubeOf(const Scene& scene, const Palette& palette, const SegmentChains& chains, std::uint32_t head,
                          const LineLook& look);

}  // namespace espalier::turtle

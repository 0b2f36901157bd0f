#pragma once

#include <cstdint>
#include <vector>

#include "engine/turtle/export/mesh.h"
#include "engine/turtle/scene.h"

namespace espalier::turtle {

/// Segments that continue each other on one axis, from the base outward: indices into Scene::segments.
using SegmentChain = std::vector<std::uint32_t>;

/// Splits the lines of a scene into chains: a segment joins its parent when it begins where the parent ends, has the
/// same material and branch order, and no earlier segment has joined there. O(segments).
[[nodiscard]] std::vector<SegmentChain> chainsOf(const Scene& scene, const std::vector<std::int32_t>& materials);

/// The rings of a chain's tube: one at each joint, in the plane between its neighbours, turned with the least twist
/// from ring to ring (a rotation-minimising frame; Wang et al. 2008). `unit`: world units per unit of width.
[[nodiscard]] std::vector<TubeRing> ringsOf(const Scene& scene, const SegmentChain& chain, double unit);

}  // namespace espalier::turtle

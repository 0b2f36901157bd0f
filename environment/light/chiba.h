#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `chiba`: light that reaches leaf spheres past each other (Chiba, Ohshida, Muraoka, Miura & Saito, The
/// Journal of Visualization and Computer Animation 5, 1994). Every query is a sphere of radius p1 (0 or less:
/// `radius`); a ray from its centre in each light direction loses light in the other spheres it meets ahead:
/// transmittance^(chord/diameter), or with `estimateIntersectionArea` 1 − (1 − transmittance)·A/πR², A the area that
/// the discs of both spheres have in common along the ray. p1 becomes the light, 0 to 1, and p2–p4 the unit vector of
/// the mean direction of the light.
///
/// Directions are the `sources` (x, y, z, weight) or, without any, the middles of the triangles of an octahedron that
/// is subdivided until there are `sampleCount`. `compatible`: the published traversal, which misses spheres
/// (published_voxels.h), and queries with two or three parameters are left out. Light below 1e-12 counts as none.
/// O(n · directions · (log n + spheres met)) through a tree of boxes.
extern const ProcessEntry kChibaProcess;

}  // namespace espalier::environment

#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `shadow` (the field's shadowpyramid): light under a canopy by shadow propagation in voxels, after
/// Palubicki et al. (2009), section 4.2, in the multiplicative form of the published program.
///
/// The grid has `gridSize` voxels a side over [-span, span] in the two horizontal directions and [0, 2 span] along the
/// world's up; voxel centres lie on the borders, so the spacing is 2 span / (gridSize - 1). A query with parameter 1
/// greater than 0 casts a shadow: in tier i = 0 .. shadowDepth - 1 below its voxel (tier 0 is the voxel's own), all
/// voxels within int(i shadowSpread) in both horizontal directions have their light multiplied by 1 - C1 C2^-d, d the
/// distance in voxels, C1 = shadowWeight, C2 = shadowDissipation. A point casts from the nearest voxel; half-way it is
/// the one further from the grid's centre. Shadows do not outlast the step, so the process has no state.
///
/// Reply: parameter 1 the light 0 .. 1 at the point, interpolated between the eight voxels around it, the query's own
/// shadow included, 1 where no voxel is shaded and outside the grid; parameters 2 to 4 the gradient of that light per
/// length unit in x, y, z: central differences over `sampleRadius`, plus lightVerticalBias along up, plus a uniform
/// random number within +-lightRandomness in each direction (a pure function of seed, step, plant and module).
///
/// Products are formed as fixed-point sums of logarithms, so replies do not depend on the order of queries, bit by bit.
/// O(n shadowDepth^3) for n queries.
extern const ProcessEntry kShadowProcess;

}  // namespace espalier::environment

#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `density3d`: counts that queries leave in the voxels of a box and that persist over the steps.
///
/// A query adds its parameter 1, truncated to a whole number (within +-2^40), to the voxel it is in, and parameter 1
/// becomes the voxel's value afterwards; outside the box nothing is added and it becomes 0. By default "afterwards" is
/// after all queries of the step, so replies do not depend on their order; with `order` "published" it is after this
/// query, in string order, as in the published program. The box begins at `position` and measures `range`; it has
/// `gridSize` voxels, or 2^octreeLevel in each direction when a level is given.
///
/// Stateful: the counts. O(1) a query; memory grows with the voxels touched.
extern const ProcessEntry kDensity3dProcess;

}  // namespace espalier::environment

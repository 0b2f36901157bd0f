#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `clover`: light on the ground under the leaves of creeping plants. Leaves are horizontal discs stamped
/// on a raster: a query with p1 = 1 adds a leaf of area p2 at its place, with any other p1 but 0 removes one; a query
/// with one parameter or p1 = 0 asks, and gets p1 = light/255 · transmittance^(leaves above) and p2 = second map/128,
/// both 0 outside the raster. Leaves stay until they are removed; all adds and removes of a step come before its
/// answers, so the order of queries does not matter. Counts are whole numbers; one below 0 (more removed than added)
/// shades nothing.
///
/// `compatible` stamps the published program's ellipses and keeps counts within 0 … 255. O(cells of the leaves) +
/// O(queries).
extern const ProcessEntry kCloverProcess;

}  // namespace espalier::environment

#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `ornament`: objects stamped on a raster that is empty again in every step. A query with two parameters
/// stamps a disc of radius p2 at its place; it gets p1 = number of objects over its cell, its own included, and p2 =
/// the light map's value, 0 to 255; both 0 outside the raster. All objects of a step are stamped before any is counted.
///
/// `compatible` stamps the published program's ellipses. O(cells of the objects) + O(queries).
extern const ProcessEntry kOrnamentProcess;

}  // namespace espalier::environment

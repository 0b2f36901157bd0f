#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `meadow`: insects that feel the density of plants around them and each other. A query with six
/// parameters is an insect. p1 becomes the mean plant density of nine samples, 3 x 3 over ±`radius`, p2 and p3 the unit
/// vector of its gradient (0 where it is flat); p4 the number of the nearest other insect within `radius`, counted from
/// 0 in the order of plants and modules, −1 when there is none; p5 and p6 the way to it. Densities are those of
/// `lightMap` in parts of 255, 0 beyond the raster; a query with one parameter adds p1 to the density of its cell for
/// this step.
///
/// `compatible`: only queries before a module I with three parameters are insects, and without a neighbour p5 and p6
/// stay as sent, where the published program leaves garbage. O(n log n), however insects crowd.
extern const ProcessEntry kMeadowProcess;

}  // namespace espalier::environment

#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `attractors`: p1–p3 become the pull of all attractors on the place, Σ strength · u/d^exponent with d the
/// distance and u the unit vector to the attractor (a negative strength pushes away); one beyond `reach` does not act
/// and one nearer than `nearest` acts as from there. p4 becomes the distance to the nearest attractor. At an attractor
/// itself it does not pull. O(queries · attractors).
extern const ProcessEntry kAttractorsProcess;

}  // namespace espalier::environment

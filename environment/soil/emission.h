#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `emission`: plants give off a substance (carbon dioxide, a scent, litter) into a field that diffuses and
/// decays, and feel what is there. A query sends p1 the amount that its organ gives off in this step; p1 becomes the
/// concentration, amount per volume, that the step before has left at its place, and p2–p4 its gradient. Then all
/// amounts are added and the step's time passes: dc/dt = D∇²c − λc over World::stepDurationDays, in as many explicit
/// steps as stability needs. Matter is conserved but for the decay and what leaves an open box; what is given off
/// outside the box is lost. Sums are sorted, so the order of queries does not matter. Cells are cubes; one slice along
/// z makes a plane field. O(n log n + cells · diffusion steps).
extern const ProcessEntry kEmissionProcess;

}  // namespace espalier::environment

#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `soil-water`: water in unsaturated ground with what is dissolved in it, and roots that take it up.
/// Richards' equation with van Genuchten's functions by layer (richards.h), any number of solutes, acidity as buffered
/// H⁺ (solutes.h), stones, rain and evaporation at the surface.
///
/// A query sends p1 the volume of water wanted in this step (negative: given off), p7 the amount of H⁺ given off, p8,
/// p10, … the amounts of the solutes wanted (negative: given off). p1 becomes the volume obtained, p2 the pressure
/// head, p3 the water content, p4–p6 its gradient, p7 the pH, p8 and p9, p10 and p11, … of each solute the amount
/// obtained and the concentration in the water. All see the state that the step before has left; outside the ground and
/// in stones all are 0. When the queries of a cell want more than there is above the content at `wiltingHead`, each
/// gets the same share of what it wants, and so with solutes; sums are sorted. Then what was obtained is taken away and
/// the step's time passes. O(n log n + cells · time steps · iterations).
extern const ProcessEntry kSoilWaterProcess;

}  // namespace espalier::environment

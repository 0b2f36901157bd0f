#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `density` (after Cohen, Nature 216, 1967): the tips of a plane pattern, and sources and sinks among
/// them, make a density field, and a tip grows down its gradient. ρ(x) = Σ over the other tips 1/(1+d²) + Σ over the
/// sources v/(1+d), d the distance in the plane.
///
/// A query with one parameter is a source of strength p1 (a sink when negative). One with three asks, and gets p1 the
/// density, p2 the angle of −∇ρ in degrees from the plane's first axis, 0 to 360, and p3 its length; with
/// `returnVector` p2 and p3 are the components of −∇ρ. Other numbers of parameters only make a tip. Without
/// `onePointValue` ρ is sampled at 6 x 6 points over ±0.5: p1 is the smallest value and ∇ρ the slope of the plane that
/// fits the samples best; with it p1 is ρ at the tip and ∇ρ central differences over ±0.5.
///
/// The tips act by the fast multipole method (tip_field.h), the sources by a quadtree (kernel_tree.h): a step costs
/// O(n log n) with an error below 1e-6 of the largest density; up to 1024 queries, and with `exact`, all pairs are
/// summed. The result does not depend on the order of queries.
extern const ProcessEntry kDensityProcess;

}  // namespace espalier::environment

#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `honda` (the field's honda81): collisions of branch tips with clusters of leaves of one radius, after
/// Honda, Tomlinson & Fisher (1981) as an open L-system (Mech & Prusinkiewicz 1996, section 4).
///
/// A query sends its vigor (parameter 1, default 0) and optionally its group (parameter 2, default 0). Parameter 1
/// becomes 0 when another query of the same group with at least the same vigor is within `radius` (its border
/// included), and 1 otherwise: equals block each other. Other parameters are left alone. In two dimensions distances
/// are measured in `plane`, by default x,z as the published program does. Radius 0 blocks only tips at the same point.
///
/// Stateless, independent of the order of queries. O(n log n) for n queries, however they are crowded.
extern const ProcessEntry kHondaProcess;

}  // namespace espalier::environment

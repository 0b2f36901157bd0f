#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `takenaka`: photosynthesis of balls of leaves that shade each other (Takenaka, Journal of Plant Research
/// 107, 1994). A query with two parameters is a ball of leaf area p1 and maintenance p2; its radius is R = s·½·√(p1/π).
/// p1 comes back, and p2 becomes its product, efficiency · p1/4 · s² · a · ΣT − maintenance: a = 1 − (1 − (1 − t)/s²)²
/// is the part of the light that a ball takes, and T what is left of a source's light after every ball on the straight
/// line to it has let pass (1 − (1 − t)/s²)². The sources give together 1000 µmol m⁻² s⁻¹ over 12 hours and 200 days a
/// year: 8640 mol m⁻², converted to the world's length unit (m, dm, cm, mm; others are refused).
///
/// `compatible`: the published traversal (published_voxels.h), balls beyond a source count too, and the published
/// program's 8.64 mol for a unit of area, ten times what its own units (cm) give. O(n · sources · (log n + balls met)).
extern const ProcessEntry kTakenakaProcess;

}  // namespace espalier::environment

#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `soil`: water or a nutrient in the ground, taken up by roots and spreading by diffusion, in the plane
/// x,y or in space (Clausnitzer & Hopmans, Plant and Soil 164, 1994; Měch & Prusinkiewicz, SIGGRAPH 1996).
///
/// A query sends p1 the amount wanted and gets what it obtained; p2 a weight of gravity and p3 one of the gradient, and
/// gets in p2–p4 weight · g + weight · ∇c, where g points down at the layer's geotropic angle and ∇c is relative to the
/// range of concentrations, per length unit; p5 the length of the next segment and p6 its divergence in degrees, and
/// gets in p5 the smallest angle, in steps of 2°, by which to turn to pass the obstacles (in space p5–p7: the
/// direction). Outside the box nothing is obtained.
///
/// All queries see the field of the step before; when they want more than a cell holds, each gets the same share of
/// what it wants. Then what was taken is gone and the field spreads. `compatible`: cells empty in string order, without
/// depletion a query gets the whole concentration, gradients are per cell, layer angles act doubled, without layers
/// gravity acts only on a vertical heading, and the averaging scheme of soil_field.h. O(n log n + cells · steps).
extern const ProcessEntry kSoilProcess;

}  // namespace espalier::environment

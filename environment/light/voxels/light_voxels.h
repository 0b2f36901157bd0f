#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `light-voxels`: light in a box of voxels, by one of two methods. The voxels are filled anew in every
/// step, so there is no state. The world's up must be along an axis.
///
/// "turbid": the leaves are a turbid medium. A query sends p1, the leaf area of its organ; a voxel has the leaf area
/// density (area per volume) of the organs in it. Light from a direction d at the angle θ from the vertical reaches a
/// point with T_d = exp(−√α G(θ) ∫ density ds) of its strength (Beer–Lambert; Monsi & Saeki 1953), G the projection of
/// the leaf angle distribution and α the absorptance of a leaf (Goudriaan 1977). p1 becomes the irradiance of a
/// horizontal plane at the point, Σ w_d T_d times `irradiance`, w_d the part of direction d in an open sky; p2–p4 its
/// gradient, between points one voxel apart; p5 what a unit of leaf area absorbs there, √α Σ w_d G/cos θ T_d times
/// `irradiance`, so that the leaves of a layer absorb what the light loses in it. O(n · directions · voxels on a ray).
///
/// "shadow": additive shadow propagation (Pałubicki et al. 2009, section 4.2). A query with p1 > 0 is p1 buds or
/// leaves, each of which adds a·b^−q to the shadow s of the voxels q = 0 … `shadowDepth` below its own with |di|, |dk|
/// ≤ q. p1 becomes Q = max(C − s + a·p1, 0) of the point's voxel, without the own shadow; p2–p4 V = −∇s, the central
/// difference between neighbouring voxels. Sums over rectangles make this O(voxels + n · shadowDepth), whatever n
/// casts.
///
/// Outside the box nothing casts; points there get their light all the same.
extern const ProcessEntry kLightVoxelsProcess;

}  // namespace espalier::environment

#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `colonization`: buds compete for space that is marked by points (space colonization). Sources: Runions,
/// Lane & Prusinkiewicz, "Modeling trees with a space colonization algorithm" (2007); Pałubicki et al.,
/// "Self-organizing tree models for image synthesis" (2009), section 4.1.
///
/// Every query occupies the space around it: markers within `occupancyRadius` ρ vanish for good. A query with p1 > 0 is
/// a bud: it perceives the markers that are left within `perceptionRadius` r and within half of `perceptionAngle` θ of
/// its heading, and each marker belongs to the nearest of the buds that perceive it (to all that are equally near). p1
/// becomes the quality of the space Q, 1 when at least one marker belongs to the bud, else 0; p2–p4 the optimal
/// direction V, the unit vector along the sum of the unit vectors to its markers (0 without markers, or when they
/// cancel); p5 their number. First all queries of a step occupy, then all buds perceive, so their order does not
/// matter. θ = 360° and ρ < r is the algorithm of 2007, with r its radius of influence and ρ its kill distance.
///
/// Markers are the given points and `markerCount` points that are uniform, by the simulation's seed, in the part of
/// `markerBox` that lies in the envelope: the solids given by the keys of `obstacles`, or everywhere when there are
/// none. O(n · markers within reach); memory and a step's base cost O(markers).
extern const ProcessEntry kColonizationProcess;

}  // namespace espalier::environment

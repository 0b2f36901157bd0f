#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `crowding`: plants share the ground by their zones of influence, thin themselves out and sow. Sources:
/// zones of influence after Gates & Westcott (1978) and Weiner et al., "The effects of density, spatial pattern, and
/// competitive symmetry on size variation in simulated plant populations" (American Naturalist 158, 2001); Deussen et
/// al. (1998).
///
/// A query with p1 > 0 is a plant with a zone of that radius on the ground; p2 is the least share of its zone with
/// which it lives (without p2: `leastShare`), p3 its strength (without p3: its radius). p1 becomes 1 when it lives,
/// else 0; p2 its share: over points spread evenly in the zone, the mean of s^a/Σ s^a, s the strengths of all zones
/// over the point and a the `asymmetry` (0: all alike; 1: by strength; "largest": the strongest take all); p3 the site
/// quality. A plant with less than its least share dies with `deathProbability`.
///
/// A query with p1 ≤ 0 is a seed: p2 is the mean distance that it flies, in all directions alike, with the density
/// (2/m)² r e^(−2r/m) over the distance r. p1 becomes 1 when it germinates, else 0; p2–p4 the place where it lies (its
/// height as sent), p5 the site quality there. It germinates with the probability site quality × `germination`, and
/// only where no zone is.
///
/// Random numbers depend on the seed, the step and the module only. Nothing outlasts a step. O(n · samples · zones over
/// a point · log n).
extern const ProcessEntry kCrowdingProcess;

}  // namespace espalier::environment

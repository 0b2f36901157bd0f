#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `wind`: p1–p3 become the velocity of the air, in length units per second, blowing along `direction`.
/// `profile` says how its speed changes with the height h above `groundHeight`, along the world's up: "constant";
/// "logarithmic", speed · ln((h − d)/z0)/ln((h0 − d)/z0) with the displacement height d, the roughness z0 and the
/// reference height h0, nothing below d + z0 (Monteith & Unsworth, Principles of Environmental Physics, 1990, section
/// 7); "power", speed · (h/h0)^exponent, nothing below the ground; "table", linear between given heights and speeds,
/// constant beyond them. O(queries).
extern const ProcessEntry kWindProcess;

}  // namespace espalier::environment

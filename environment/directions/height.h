#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `height`: p1 becomes the height of the queried point above the world's origin, in length units, measured
/// along World::up. It has no configuration and no state. The teaching example of open L-systems: an apex asks how high
/// it is and stops. O(queries).
extern const ProcessEntry kHeightProcess;

}  // namespace espalier::environment

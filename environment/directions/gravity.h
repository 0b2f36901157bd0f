#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `gravity`: p1–p3 become the vector of a constant force, for tropisms: `strength` times the direction,
/// against the world's up unless `direction` is given. O(queries).
extern const ProcessEntry kGravityProcess;

}  // namespace espalier::environment

#pragma once

#include <memory>

#include "engine/simulation/forest.h"
#include "engine/simulation/simulation.h"
#include "server/language_server/run_counts.h"

namespace espalier::server {

/// The counts of all productions that steps can apply, in the order of the texts; also of those that were not applied.
[[nodiscard]] RunCounts runCounts(const simulation::Programs& programs, const simulation::ProductionUses& uses);

}  // namespace espalier::server

#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/turtle/environment_process.h"

namespace espalier::environment {

/// An ordered set of named processes as one process. The queries of plain ?E go to the first; those of a declared ?Name
/// to the process of that name (letter case aside). An unknown name is an error that lists the known ones. A single
/// process with an empty name takes all queries, whatever their names, and is returned as it is.
///
/// Each process gets its own queries of a step in one batch, in the order of the whole batch, or a tick when it has
/// none. If one process fails, the others go back to their state before the step. save() and restore() cover all
/// processes. O(queries + parameters) besides the processes, and a copy of the state of all stateful processes but one.
/// `processes` must not be empty, and no process may be null.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makeEnvironmentSet(
    std::vector<std::pair<std::string, std::unique_ptr<turtle::EnvironmentProcess>>> processes);

}  // namespace espalier::environment

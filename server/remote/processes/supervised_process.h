#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// The supervision of a process inside this program: of a plug-in, or of any process when a time limit is set.
struct Supervision {
  std::chrono::milliseconds stepTimeout{60'000};
  /// The process anew, as it was made first, from the same configuration. Null when that fails.
  std::function<std::unique_ptr<turtle::EnvironmentProcess>()> again;
};

/// Runs the process on a thread of its own, with a copy of its queries. A call fails with an error that names the
/// process when it takes longer than `stepTimeout` (real time, for open, step and tick), throws, or answers with a
/// number that is not finite. Its state is then the one before the call, and the next call asks again. A thread cannot
/// be stopped from outside: a thread that hangs keeps the old instance until the program ends, and `again` makes a new
/// instance. Costs a copy of the queries and, for a process with state, one save() a step.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> supervised(
    std::unique_ptr<turtle::EnvironmentProcess> process, Supervision supervision);

}  // namespace espalier::server

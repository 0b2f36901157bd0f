#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// A process inside this program that is not trusted to come back: a plug-in, or any other when a time is set.
struct Supervision {
  std::chrono::milliseconds stepTimeout{60'000};
  /// The process anew, as it was made first, from the same configuration. Null when that fails.
  std::function<std::unique_ptr<turtle::EnvironmentProcess>()> again;
};

/// The process on a thread of its own, with a copy of what it is asked. When it takes longer than `stepTimeout` (of
/// real time, for opening, for a step and for a tick), when it throws, or when it answers with a number that is not
/// finite, the call fails with an error that names it; its state is then the one before the call, and the next call
/// asks again. Nothing stops a thread from outside: one that hangs is left alone with the old instance and ends with
/// the program, while `again` makes the instance that takes its place. Costs a copy of the queries and, of a process
/// with state, one save() a step.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> supervised(
    std::unique_ptr<turtle::EnvironmentProcess> process, Supervision supervision);

}  // namespace espalier::server

#pragma once

#include <exception>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "engine/core/simulation_error.h"
#include "engine/turtle/environment_process.h"

namespace espalier::turtle {

/// Calls an environment process; an exception that leaves it is an error that names the process, like any it returns.
/// `name` is for messages only. A process that throws has to be as before the call, like one that returns an error:
/// those built in are, and one from outside is watched by somebody who can bring its state back.
template <typename Call>
[[nodiscard]] std::optional<EnvironmentError> guardedCall(const std::string& name, Call&& call) {
  try {
    return std::forward<Call>(call)();
  } catch (const core::SimulationFailure&) {
    throw;
  } catch (const std::bad_alloc&) {
    return EnvironmentError{"environment '" + name +
                                "' has not enough memory for this step. Use smaller grids, fewer plants or a machine "
                                "with more memory.",
                            true};
  } catch (const std::exception& exception) {
    return EnvironmentError{"environment '" + name + "' failed with an exception: " + exception.what() + ".", false};
  } catch (...) {
    return EnvironmentError{"environment '" + name + "' failed with an exception that says nothing.", false};
  }
}

}  // namespace espalier::turtle

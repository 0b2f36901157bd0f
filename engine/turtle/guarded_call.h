#pragma once

#include <exception>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "engine/core/simulation_error.h"
#include "engine/turtle/environment_process.h"

namespace espalier::turtle {

/// Calls an environment process and turns an exception into an error that names the process. `name` is for messages
/// only. As after an error, the process must be in its state before the call. The built-in processes are; the server
/// restores the state of a process from outside.
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

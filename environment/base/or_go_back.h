#pragma once

#include <utility>

namespace espalier::environment {

/// Makes a step of a process whose state is `state`. A step that ends with an exception, as when it is given up
/// (core::WorkStopped), leaves the state as it was.
template <typename State, typename Step>
auto orGoBack(State& state, Step&& step) {
  State before = state;
  try {
    return std::forward<Step>(step)();
  } catch (...) {
    state = std::move(before);
    throw;
  }
}

}  // namespace espalier::environment

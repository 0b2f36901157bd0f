#pragma once

#include <memory>
#include <vector>

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `multiple`: several environments at once, chosen by number. Parameter 1 of a query is the number of the
/// environment, from 1, truncated. That environment gets the query without parameter 1, and its replies go to the
/// parameters after it. Parameter 1 is never set. An unknown number is an error; with `compatible` such a query is left
/// unanswered.
///
/// The key `fields` lists the environments as a simulation's configuration does. None of them can be `multiple` itself.
/// All environments advance in a step or, when one fails, none. O(queries + parameters) besides the environments.
extern const ProcessEntry kMultipleProcess;

/// The same for processes that exist already: those of published `.e` files. At least one.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makeMultiple(
    std::vector<std::unique_ptr<turtle::EnvironmentProcess>> members, bool isCompatible);

}  // namespace espalier::environment

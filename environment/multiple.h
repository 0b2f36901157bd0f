#pragma once

#include <memory>
#include <vector>

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `multiple`: several fields at once, chosen by number. Parameter 1 of a query is the number of the field,
/// from 1, truncated; the field gets the query without it, and its replies go to the parameters after it. Parameter 1
/// is never set. A number that no field has is an error; with `compatible` such a query is left unanswered.
///
/// `fields` lists the fields as a simulation's configuration lists environments. A field cannot be `multiple` itself.
/// All fields advance in a step or, when one fails, none. O(queries + parameters) besides the fields.
extern const ProcessEntry kMultipleProcess;

/// The same of processes that exist already (the field's `.e` files). At least one.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makeMultiple(
    std::vector<std::unique_ptr<turtle::EnvironmentProcess>> fields, bool isCompatible);

}  // namespace espalier::environment

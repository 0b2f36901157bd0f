#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `constant`: every query gets the same configured `values` (default: 1), as many as it has parameters.
/// For tests and for trying out a model without its environment. No state. O(parameters).
extern const ProcessEntry kConstantProcess;

}  // namespace espalier::environment

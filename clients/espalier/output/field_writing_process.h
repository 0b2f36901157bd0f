#pragma once

#include <memory>

#include "clients/espalier/output/field_outputs.h"
#include "engine/turtle/environment_process.h"

namespace espalier::command {

/// The same process, which also writes its quantities in space after every step, as `outputs` says: for an environment
/// that runs as a program of its own, where the simulation does not see them. With `isEveryStepWritten` files but
/// tables are numbered by step, else those of the last step stay. A file that cannot be written is an error of the
/// step. `outputs` must outlive it.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> writingFields(
    std::unique_ptr<turtle::EnvironmentProcess> process, FieldOutputs& outputs, bool isEveryStepWritten);

}  // namespace espalier::command

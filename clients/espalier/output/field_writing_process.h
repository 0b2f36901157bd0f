#pragma once

#include <memory>

#include "clients/espalier/output/field_outputs.h"
#include "engine/turtle/environment_process.h"

namespace espalier::command {

/// The same process, which also writes its quantities in space to `outputs` after every step. An environment in its own
/// process needs this, because the simulation does not receive these quantities. With `isEveryStepWritten` every step
/// has its own numbered files, except tables; else the files of the last step remain. A file that cannot be written is
/// an error of the step. `outputs` must outlive the process.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> writingFields(
    std::unique_ptr<turtle::EnvironmentProcess> process, FieldOutputs& outputs, bool isEveryStepWritten);

}  // namespace espalier::command

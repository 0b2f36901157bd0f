#pragma once

#include <optional>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/files/data_file.h"
#include "engine/files/view_settings.h"

namespace espalier::language {

/// A spline function that is 0 everywhere: what a function file with an error gives, so that the ids of the following
/// functions stay.
[[nodiscard]] SplineFunction zeroFunction();

/// Reads a `.func` file, version 1.1 (`fver 1 1`) or the old format (`range:` and `points:`). `sampleCount` is the view
/// command's, used by the old format alone. What is wrong is a warning and gives zeroFunction().
[[nodiscard]] SplineFunction readFunctionFile(const DataFile& file, std::optional<int> sampleCount);

/// Reads a `.fset` file: functions in file order, each named by its macro (the `name:` up to its last point). After an
/// item with an error the Espalier mode goes on with the next item; the compatible modes stay where the error was
/// found, as the reference does.
[[nodiscard]] std::vector<SplineFunction> readFunctionSet(const DataFile& file, core::Compatibility compatibility);

}  // namespace espalier::language

#pragma once

#include <optional>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/files/data_file.h"
#include "engine/files/view_settings.h"

namespace espalier::files {

/// A spline function that is 0 everywhere. It takes the place of a function file with an error, so that the ids of the
/// following functions stay.
[[nodiscard]] SplineFunction zeroFunction();

/// Reads a `.func` file, version 1.1 (`fver 1 1`) or the old format (`range:` and `points:`). `sampleCount` is the
/// number in the view command; only the old format uses it. A mistake gives a warning and zeroFunction().
[[nodiscard]] SplineFunction readFunctionFile(const DataFile& file, std::optional<int> sampleCount);

/// Reads a `.fset` file: functions in file order, each named by its macro (the `name:` up to its last point). After an
/// item with an error the Espalier mode continues with the next item; the compatible modes continue at the error, as
/// the reference does.
[[nodiscard]] std::vector<SplineFunction> readFunctionSet(const DataFile& file, core::Compatibility compatibility);

}  // namespace espalier::files

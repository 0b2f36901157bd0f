#pragma once

#include "engine/files/data_file.h"
#include "engine/files/view_settings.h"

namespace espalier::files {

/// The default sample count of a `curve:` command.
inline constexpr int kDefaultCurveSamples = 100;

/// A curve that is the origin everywhere and has no length. It takes the place of a curve file with an error, so that
/// the ids of the following curves stay.
[[nodiscard]] ParametricCurve zeroCurve();

/// Reads a curve file (docs/model-files.md, 9). A mistake gives a warning and zeroCurve().
[[nodiscard]] ParametricCurve readCurveFile(const DataFile& file, int sampleCount);

}  // namespace espalier::files

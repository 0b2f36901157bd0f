#pragma once

#include "engine/files/data_file.h"
#include "engine/files/view_settings.h"

namespace espalier::language {

/// The default sample count of a `curve:` command.
inline constexpr int kDefaultCurveSamples = 100;

/// A curve that is the origin everywhere and has no length: what a curve file with an error gives, so that the ids of
/// the following curves stay.
[[nodiscard]] ParametricCurve zeroCurve();

/// Reads a curve file (FILES §9). What is wrong is a warning and gives zeroCurve().
[[nodiscard]] ParametricCurve readCurveFile(const DataFile& file, int sampleCount);

}  // namespace espalier::language

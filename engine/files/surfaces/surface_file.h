#pragma once

#include <optional>

#include "engine/files/data_file.h"
#include "engine/files/view_settings.h"

namespace espalier::language {

/// Reads a bicubic surface `.s` and brings it to the turtle's local coordinates: relative to the contact point, scaled
/// by scale / SIZE, turned by HEADING and UP (FILES §6.1, steps 1 to 3). Subdivisions of 0 are taken from the file;
/// they end in 1 to 10. What is wrong is a warning and gives nothing: the surface is then undefined, as in the
/// reference.
[[nodiscard]] std::optional<Surface> readSurfaceFile(const DataFile& file, char id, double scale, int subdivisionS,
                                                     int subdivisionT);

/// Reads a triangle surface (FILES §7) with its positions multiplied by the scale. A vertex without a normal gets that
/// of its triangle. What is wrong is a warning and gives nothing.
[[nodiscard]] std::optional<TriangleSurface> readTriangleSurfaceFile(const DataFile& file, char id, double scale);

}  // namespace espalier::language

#pragma once

#include <optional>

#include "engine/files/data_file.h"
#include "engine/files/view_settings.h"

namespace espalier::files {

/// Reads a bicubic surface `.s` and brings it to the turtle's local coordinates: relative to the contact point, scaled
/// by scale / SIZE, turned by HEADING and UP (docs/model-files.md, 6.1). A subdivision of 0 is taken from
/// the file; the result is 1 to 10. A mistake gives a warning and no surface: it is then undefined, as in the
/// reference.
[[nodiscard]] std::optional<Surface> readSurfaceFile(const DataFile& file, char id, double scale, int subdivisionS,
                                                     int subdivisionT);

/// Reads a triangle surface (docs/model-files.md, 7) with its positions multiplied by the scale. A
/// vertex without a normal gets the normal of its triangle. A mistake gives a warning and no surface.
[[nodiscard]] std::optional<TriangleSurface> readTriangleSurfaceFile(const DataFile& file, char id, double scale);

}  // namespace espalier::files

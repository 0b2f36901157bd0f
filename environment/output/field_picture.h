#pragma once

#include <string>

#include "engine/files/images/image_file.h"
#include "environment/output/field_output.h"

namespace espalier::environment {

/// A field's slice or projection as a figure: its name, unit and view above; the plane in colours (colourPlane) with
/// cells as wide and high as they are; coordinates below and at the left; at the right a bar that tells which number a
/// colour is. O(pixels).
[[nodiscard]] files::Image drawField(const turtle::Field& field, const FieldView& view, const FieldPlane& plane);

}  // namespace espalier::environment

#pragma once

#include <string>
#include <string_view>

#include "engine/turtle/environment_process.h"
#include "environment/geometry/shapes.h"

namespace espalier::environment {

/// Tells the user when not one query lies in or close to the box of a process, since its answers then say nothing about
/// the plant. Axes along which the box is infinite are left out of the message. Close is a tenth of the box's size.
/// O(1) when the first query lies in the box, else O(queries).
void noteIfAllAreOutside(std::string_view process, const Bounds& box, const std::string& lengthUnit,
                         const turtle::QueryBatch& queries, turtle::ReplyBatch& replies);

}  // namespace espalier::environment

#pragma once

#include "engine/turtle/environment_process.h"
#include "environment/soil/soil_field.h"

namespace espalier::environment {

/// A vector turned about a unit axis, counter-clockwise.
[[nodiscard]] core::Vec3 rotated(const core::Vec3& v, const core::Vec3& axis, double radians);

/// Answers the fifth and later parameters of a query: p5 is the length of the next segment, p6 its divergence. The
/// answer is the least turn, in steps of 2 degrees to both sides, after which the segment meets no obstacle: in a plane
/// an angle in p5, in space a direction in p5 to p7. Queries with fewer than five parameters get nothing.
void answerAvoidance(const SoilField& field, const turtle::QueryBatch& queries, std::size_t query,
                     turtle::ReplyBatch& replies);

}  // namespace espalier::environment

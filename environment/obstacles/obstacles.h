#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `obstacles`: may this segment grow? A query sends p1 the length of the segment along its heading and p2
/// its radius, and gets p1 = 1 when the segment with round ends touches no obstacle, else 0; p2 the distance to the
/// nearest obstacle, negative inside one; p3–p5 the nearest point of its surface; p6–p8 the normal there, out of the
/// obstacle; p9 how far the heading is free; p10 how long a segment of that radius along the heading may be before it
/// touches an obstacle or a segment that blocks it. Distances beyond `reach` come back as `reach`, and then p3–p8 stay
/// as sent.
///
/// Obstacles are half-spaces, boxes, spheres, capsules, a height field and meshes (obstacle_scene.h). With `plants`
/// "proposed" the segments that other plants want to grow in the same step block too (both, so that the order does not
/// matter); with "remembered" also all that other plants have grown, and with "drawn" all that other plants draw in the
/// step (`Geometry::segments`, each as thick as at its thicker end). A plant does not block itself. O((n + m) log (n +
/// m)) for n queries and m shapes, triangles and remembered segments that do not all overlap.
extern const ProcessEntry kObstaclesProcess;

}  // namespace espalier::environment

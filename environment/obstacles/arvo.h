#pragma once

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The process `arvo`: plants that climb on obstacles (Arvo & Kirk, Modeling plants with environment-sensitive
/// automata, Ausgraph 1988; Greene, Computer Graphics 23, 1989). The turtle's up vector is the normal of the surface
/// below it.
///
/// A query with seven or more parameters asks for the next segment of length p1: the turtle's heading, turned in the
/// plane across up by 0, then alternately to both sides, leads to candidates Q; the nearest surface point S within
/// `maxSurfaceDistance` of a candidate, lifted along its normal to `surfaceDistance`, is the segment's end if neither
/// it nor the way there is in an obstacle. p1–p3 become the heading of the segment, p4 its length (0: there is none),
/// p5–p7 the normal there. A query with one to six parameters becomes p1 = 1 when a surface lies within p1 along the
/// heading and p2–p4 its normal, else p1 = 0. With `addObjects` a query without parameters adds a solid that stays: a
/// sphere when the following module is S(radius), a capsule when it is C(radius, length), along the heading;
/// `removeObjects` forgets them again after the next step.
///
/// `compatible`: the nearest surface is sought by a ray along −up and then by `triesForSurface` random ones, as
/// published; the default finds it exactly and draws nothing. O(n · tries · log m) for m shapes.
extern const ProcessEntry kArvoProcess;

}  // namespace espalier::environment

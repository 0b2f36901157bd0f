#pragma once

#include <string>

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The keywords of soil's specification that have forms of their own; each sets the keys of the process `soil`.
/// `array: nx ny nz min max` with nx·ny·nz numbers on the lines below. With `obstacles and sources: on` above it values
/// ≤ min are obstacles, values ≥ max sources.
[[nodiscard]] std::string readArray(const PublishedLineInput& input);
/// `image: min max FILE`: brightness 0 is min, 255 is max. With `obstacles and sources: on` above it green is the
/// brightness, white is a source, and (40, 55, 70) or red = blue > 0 is an obstacle.
[[nodiscard]] std::string readSoilImage(const PublishedLineInput& input);
/// `3D primitives: FILE`, a background scene: its solids are obstacles.
[[nodiscard]] std::string readPrimitives(const PublishedLineInput& input);
/// `diffusion: n [tolerance]`: n sweeps, or with n = -1 until the tolerance is met.
[[nodiscard]] std::string readDiffusion(const PublishedLineInput& input);
/// `layer thicknesses: 2+3`.
[[nodiscard]] std::string readThicknesses(const PublishedLineInput& input);
[[nodiscard]] std::string readAngles(const PublishedLineInput& input);

}  // namespace espalier::environment

#pragma once

#include <string>

#include "environment/base/process_entry.h"

namespace espalier::environment {

/// The keywords of soil's specification that have forms of their own; each sets the keys of the process `soil`.
/// `array: nx ny nz min max` with nx·ny·nz numbers on the lines below.
[[nodiscard]] std::string readArray(const PublishedLineInput& input);
/// `image: FILE [min max]`: green 0 is min, 255 is max.
[[nodiscard]] std::string readConcentrationImage(const PublishedLineInput& input);
/// `obstacles and sources: FILE`, an image: red is an obstacle, green a source.
[[nodiscard]] std::string readObstacleImage(const PublishedLineInput& input);
/// `3D primitives: FILE`, a background scene: its solids are obstacles.
[[nodiscard]] std::string readPrimitives(const PublishedLineInput& input);
/// `diffusion: steps [tolerance]`.
[[nodiscard]] std::string readDiffusion(const PublishedLineInput& input);
[[nodiscard]] std::string readThicknesses(const PublishedLineInput& input);
[[nodiscard]] std::string readAngles(const PublishedLineInput& input);

}  // namespace espalier::environment

#pragma once

#include <cstddef>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// A unit vector towards the light and the part of all light that comes from there.
struct LightDirection {
  core::Vec3 direction;
  double weight = 0.0;
};

struct SkyShape {
  std::size_t sampleCount = 20;    // rounded up to 8·4^k
  double lowerToUpperRatio = 0.7;  // brightness from below relative to that from above
  bool isOvercast = false;         // the CIE standard overcast sky; otherwise uniform
};

/// Directions over the whole sphere: the middles of the triangles of an octahedron whose sides are halved until there
/// are enough. A direction has the weight of its triangle's solid angle times the brightness there. Weights sum to 1.
/// `up` is a unit vector. O(directions).
[[nodiscard]] std::vector<LightDirection> sampleSky(const SkyShape& sky, const core::Vec3& up);

/// Weights divided by their sum; directions made unit vectors. Nothing changes when the sum is 0.
void normaliseLight(std::vector<LightDirection>& directions);

}  // namespace espalier::environment

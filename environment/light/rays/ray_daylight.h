#pragma once

#include <vector>

#include "engine/core/vec3.h"
#include "environment/light/daylight.h"
#include "environment/light/rays/leaf_light.h"
#include "environment/light/rays/ray_directions.h"
#include "environment/light/sky.h"

namespace espalier::environment {

/// The light of a step as rays see it.
struct RayDaylight {
  std::vector<LeafLight::Sun> suns;  // irradiance by band, W/m²
  std::vector<double> sky;           // radiance of the whole spectrum by direction, W m⁻² sr⁻¹
  double diffuse = 0.0;              // irradiance of a horizontal plane by the sky, whole spectrum
};

/// The suns in bands with these parts of the irradiance. The skies give a horizontal plane their irradiance as the
/// directions of each lattice sum it up. O(skies · directions).
[[nodiscard]] RayDaylight onRays(const Daylight::Incoming& incoming, SkyKind kind, const std::vector<double>& parts,
                                 const RayDirections& directions, const core::Vec3& up);

}  // namespace espalier::environment

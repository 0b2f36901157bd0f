#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/environment_process.h"
#include "environment/base/configuration.h"
#include "environment/light/rays/leaf_light.h"
#include "environment/light/rays/ray_directions.h"
#include "environment/light/sky.h"

namespace espalier::environment {

/// The sun and the sky of the process `light`, before they meet a plant (light.cpp says how strong they are).
class Daylight {
 public:
  /// The light of a step.
  struct Incoming {
    std::vector<LeafLight::Sun> suns;  // irradiance by band, W/m²
    std::vector<double> sky;           // radiance of the whole spectrum by direction, W m⁻² sr⁻¹
  };

  explicit Daylight(const Configuration& configuration);

  /// Sets place and time from the world. The error is a sentence without its subject, the name of the environment.
  [[nodiscard]] std::optional<std::string> open(const turtle::World& world);

  /// The light of the step that begins so many days after the start, its mean over the step. O(suns · directions).
  [[nodiscard]] Incoming at(double timeDays, const RayDirections& directions) const;

 private:
  void addSun(const core::Vec3& direction, double irradiance, Incoming& incoming) const;
  void addSky(const RayDirections& directions, const core::Vec3& sun, double irradiance,
              std::vector<double>& sky) const;

  Configuration configuration_;
  std::string sun_;  // none, direction, position
  SkyKind skyKind_;
  core::Vec3 up_{0, 1, 0};
  core::Vec3 north_{0, 0, -1};
  core::Vec3 sunDirection_{0, 1, 0};
  double startDay_ = 0.0;  // Julian day
  double latitude_ = 0.0;
  double longitude_ = 0.0;
  double stepDays_ = 1.0;
};

}  // namespace espalier::environment

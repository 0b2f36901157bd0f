#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
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
    double diffuse = 0.0;              // irradiance of a horizontal plane by the sky, whole spectrum
  };

  explicit Daylight(const Configuration& configuration);

  /// Sets place and time from the world. The error is a sentence without its subject, the name of the environment.
  [[nodiscard]] std::optional<std::string> open(const turtle::World& world);

  /// The light of the step that begins so many days after the start, its mean over the step. Radiation of the world's
  /// weather takes the place of the configuration's. The error is a sentence as in open(). O(suns · directions).
  [[nodiscard]] tl::expected<Incoming, std::string> at(double timeDays, const RayDirections& directions) const;

 private:
  /// Radiation between two times, days after the start: of the sun on a plane that faces it, of the sky on a horizontal
  /// one.
  struct Radiation {
    double direct = 0.0;
    double diffuse = 0.0;
  };
  /// From two of the weather's global, direct and diffuse radiation; `sine` is that of the sun's elevation.
  [[nodiscard]] tl::expected<Radiation, std::string> measured(double from, double to, double sine) const;
  /// Days of a step at the same hours.
  struct Span {
    double begin = 0.0;     // days after the start
    double length = 1.0;    // of each day that is looked at
    std::int64_t days = 1;  // one after the other
    double part = 1.0;      // of the step
  };
  [[nodiscard]] std::optional<std::string> addHours(const Span& span, const RayDirections& directions,
                                                    Incoming& incoming) const;
  void addSun(const core::Vec3& direction, double irradiance, Incoming& incoming) const;
  void addSky(const RayDirections& directions, const core::Vec3& sun, double irradiance, Incoming& incoming) const;

  Configuration configuration_;
  std::string sun_;  // none, direction, position
  SkyKind skyKind_;
  std::vector<double> parts_;  // of the irradiance in each band
  core::Vec3 up_{0, 1, 0};
  core::Vec3 north_{0, 0, -1};
  std::vector<core::Vec3> sunDirections_;  // of a sun by its direction
  double startDay_ = 0.0;                  // Julian day
  double latitude_ = 0.0;
  double longitude_ = 0.0;
  double stepDays_ = 1.0;
  turtle::World world_;
  bool hasMeasured_ = false;  // the weather has radiation
};

}  // namespace espalier::environment

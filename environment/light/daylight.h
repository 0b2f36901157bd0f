#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/environment_process.h"
#include "environment/base/configuration.h"

namespace espalier::environment {

/// The sun and the sky of `light` and `light-voxels`, before they meet a plant. With the sun by position its strength
/// is 1361 W/m² at the mean distance, times τ^m through air of the optical mass m = 1/sin(elevation). The sky has 0.3
/// (1 − τ^m) of the light that the sun would give a horizontal plane (Liu & Jordan 1960; Campbell & Norman 1998).
class Daylight {
 public:
  struct Sun {
    core::Vec3 direction;     // a unit vector towards it
    double irradiance = 0.0;  // of a plane that faces it, W/m²
  };
  struct Sky {
    core::Vec3 sun;           // a unit vector to where a clear sky is brightest
    double irradiance = 0.0;  // of a horizontal plane, W/m²
  };
  /// The light of a step.
  struct Incoming {
    std::vector<Sun> suns;
    std::vector<Sky> skies;  // one on another
  };

  /// Reads the keys of daylight_keys.h. `openSky`: irradiance of a horizontal plane by the sky when there is no sun.
  Daylight(const Configuration& configuration, double openSky);

  /// Sets place and time from the world. The error is a sentence without its subject, the name of the environment.
  [[nodiscard]] std::optional<std::string> open(const turtle::World& world);

  /// The light of the step that begins so many days after the start, its mean over the step. Radiation of the world's
  /// weather takes the place of the configuration's. The error is a sentence as in open(). O(suns).
  [[nodiscard]] tl::expected<Incoming, std::string> at(double timeDays) const;

  /// Suns that stand in these directions in every step; none when the sun moves or there is none.
  [[nodiscard]] const std::vector<core::Vec3>& fixedSuns() const { return sunDirections_; }
  /// Whether the weather has radiation. Known after open().
  [[nodiscard]] bool isMeasured() const { return hasMeasured_; }

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
  [[nodiscard]] std::optional<std::string> addHours(const Span& span, Incoming& incoming) const;

  Configuration configuration_;
  std::string sun_;  // none, direction, position
  double openSky_;
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

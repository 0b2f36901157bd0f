#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/world.h"
#include "environment/base/configuration.h"
#include "environment/light/daylight.h"
#include "environment/light/light_directions.h"

namespace espalier::environment {

/// Where the light of `light-voxels` comes from in a step: directions of a sky at Gauss points, or those of the
/// configuration, and the sun of daylight.h.
class VoxelSources {
 public:
  struct Source {
    core::Vec3 direction;     // a unit vector towards the light
    double weight = 0.0;      // part of all light that comes down on a horizontal plane
    double cosine = 1.0;      // of the angle to the vertical
    double projection = 0.0;  // G of the leaves
  };

  explicit VoxelSources(const Configuration& configuration);

  /// Sets place, time and the directions that stay. The error is a sentence without its subject, the name of the
  /// environment.
  [[nodiscard]] std::optional<std::string> open(const turtle::World& world);

  /// Goes to the step that begins so many days after the start: the means over the step. The error as in open(); then
  /// nothing has changed.
  [[nodiscard]] std::optional<std::string> begin(double timeDays);

  /// The first fixedCount() have the same directions in every step.
  [[nodiscard]] const std::vector<Source>& all() const { return sources_; }
  [[nodiscard]] std::size_t fixedCount() const { return fixedCount_; }
  /// Of an open horizontal plane in the step, all bands together; with relative light 1, and 0 without any light.
  [[nodiscard]] double irradiance() const { return irradiance_; }
  /// Whether the irradiance is in W/m² of the sun or the weather, and not in the user's unit. Known after open().
  [[nodiscard]] bool isInWatts() const { return !isRelative_ && (sun_ != "none" || daylight_.isMeasured()); }

 private:
  [[nodiscard]] Source sourceOf(const core::Vec3& direction) const;
  [[nodiscard]] std::vector<LightDirection> skyWith(const core::Vec3& sun) const;

  Configuration configuration_;
  std::string sun_;  // none, direction, position
  bool isRelative_;
  Daylight daylight_;
  core::Vec3 up_{0, 1, 0};
  std::vector<Source> sources_;
  std::size_t skyCount_ = 0;  // the first sources: sky, or the configuration's directions
  std::size_t fixedCount_ = 0;
  double irradiance_ = 0.0;
};

}  // namespace espalier::environment

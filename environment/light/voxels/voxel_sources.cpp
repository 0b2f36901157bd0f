#include "environment/light/voxels/voxel_sources.h"

#include <utility>

#include "environment/light/daylight_keys.h"
#include "environment/light/sky.h"
#include "environment/light/voxels/leaf_angles.h"

namespace espalier::environment {

using core::Vec3;

VoxelSources::VoxelSources(const Configuration& configuration)
    : configuration_(configuration),
      sun_(configuration.text("sun")),
      isRelative_(configuration.text("unit") == "relative"),
      daylight_(configuration, configuration.number("irradiance")) {}

std::optional<std::string> VoxelSources::open(const turtle::World& world) {
  constexpr const char* kFromBelow =
      "takes light from above only: in 'directions' every direction must be above the horizon and no weight below 0.";
  up_ = core::normalised(world.up);
  if (auto problem = daylight_.open(world)) {
    return problem;
  }
  sources_.clear();
  std::vector<LightDirection> lights;
  for (const auto& row : configuration_.rows("directions")) {
    if (row[3] < 0.0) {
      return kFromBelow;
    }
    lights.push_back({{row[0], row[1], row[2]}, row[3]});
  }
  if (lights.empty()) {
    lights = skyWith(up_);
  } else {
    normaliseLight(lights);
  }
  for (const LightDirection& light : lights) {
    if (!(core::dot(light.direction, up_) > 1e-6)) {
      return kFromBelow;
    }
    sources_.push_back(sourceOf(light.direction));
    sources_.back().weight = light.weight;
  }
  skyCount_ = sources_.size();
  for (const Vec3& sun : daylight_.fixedSuns()) {
    sources_.push_back(sourceOf(sun));
  }
  fixedCount_ = sources_.size();
  // the irradiance that is known before the first step
  irradiance_ = isInWatts() ? 0.0 : isRelative_ ? 1.0 : configuration_.number("irradiance");
  return std::nullopt;
}

std::optional<std::string> VoxelSources::begin(double timeDays) {
  if (isRelative_ && sun_ == "none") {
    return std::nullopt;
  }
  const auto incoming = daylight_.at(timeDays);
  if (!incoming) {
    return incoming.error();
  }
  double diffuse = 0.0;
  double all = 0.0;
  for (const Daylight::Sky& sky : incoming->skies) {
    diffuse += sky.irradiance;
  }
  all = diffuse;
  for (const Daylight::Sun& sun : incoming->suns) {
    all += sun.irradiance * core::dot(sun.direction, up_);
  }
  irradiance_ = isRelative_ ? (all > 0.0 ? 1.0 : 0.0) : all;
  const auto partOf = [](double light, double whole) { return whole > 0.0 ? light / whole : 0.0; };
  if (configuration_.text("sky") == "clear") {
    for (std::size_t k = 0; k < skyCount_; ++k) {
      sources_[k].weight = 0.0;
    }
    for (const Daylight::Sky& sky : incoming->skies) {
      const std::vector<LightDirection> own = skyWith(sky.sun);
      for (std::size_t k = 0; k < skyCount_; ++k) {
        sources_[k].weight += own[k].weight * partOf(sky.irradiance, all);
      }
    }
  } else if (sun_ != "none") {
    const std::vector<LightDirection> own = skyWith(up_);
    for (std::size_t k = 0; k < skyCount_; ++k) {
      sources_[k].weight = own[k].weight * partOf(diffuse, all);
    }
  }
  // a sun by its direction shines from where it stood at the start
  sources_.resize(fixedCount_);
  for (std::size_t k = 0; k < incoming->suns.size(); ++k) {
    const Daylight::Sun& sun = incoming->suns[k];
    const bool isFixed = sun_ == "direction";
    if (!isFixed) {
      sources_.push_back(sourceOf(sun.direction));
    }
    Source& source = isFixed ? sources_[skyCount_ + k] : sources_.back();
    source.weight = partOf(sun.irradiance * source.cosine, all);
  }
  return std::nullopt;
}

VoxelSources::Source VoxelSources::sourceOf(const Vec3& direction) const {
  Source source{direction, 0.0, core::dot(direction, up_), 0.0};
  source.projection = leafProjection(leafAnglesOf(configuration_.text("leafAngles")), source.cosine,
                                     configuration_.number("ellipsoidRatio"));
  return source;
}

std::vector<LightDirection> VoxelSources::skyWith(const Vec3& sun) const {
  return skyRings(skyKindOf(configuration_), static_cast<int>(configuration_.integer("zenithAngles")),
                  static_cast<int>(configuration_.integer("azimuthAngles")), up_, sun);
}

}  // namespace espalier::environment

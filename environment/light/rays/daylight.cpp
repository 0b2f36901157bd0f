#include "environment/light/rays/daylight.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "engine/core/elementary.h"
#include "environment/light/sun_position.h"

namespace espalier::environment {

using core::Vec3;
using std::numbers::pi;

Daylight::Daylight(const Configuration& configuration)
    : configuration_(configuration),
      sun_(configuration.text("sun")),
      skyKind_(static_cast<SkyKind>(std::find(kSkyNames.begin(), kSkyNames.end(), configuration.text("sky")) -
                                    kSkyNames.begin())) {}

std::optional<std::string> Daylight::open(const turtle::World& world) {
  up_ = core::normalised(world.up);
  if (sun_ == "position") {
    const std::string& own = configuration_.text("start");
    const auto start = julianDayOf(own.empty() ? world.start : own);
    if (!start || (own.empty() && !world.latitudeDegrees)) {
      return "needs to know where and when it is for the position of the sun: set 'latitude', 'longitude' and "
             "'start', here or in the world (\"2026-06-21\" or \"2026-06-21T12:00\", universal time).";
    }
    startDay_ = *start;
    latitude_ = own.empty() ? *world.latitudeDegrees : configuration_.number("latitude");
    longitude_ = own.empty() ? world.longitudeDegrees.value_or(0.0) : configuration_.number("longitude");
    north_ = core::normalised(world.north - up_ * core::dot(world.north, up_));
    stepDays_ = world.stepDurationDays;
  } else if (sun_ == "direction") {
    const auto& direction = configuration_.numbers("sunDirection");
    sunDirection_ = core::normalised({direction[0], direction[1], direction[2]});
    if (!(core::dot(sunDirection_, up_) > 1e-6)) {
      return "has its sun below the horizon. Give a 'sunDirection' that points up to the sun.";
    }
  }
  return std::nullopt;
}

Daylight::Incoming Daylight::at(double timeDays, const RayDirections& directions) const {
  Incoming incoming;
  incoming.sky.assign(directions.all().size(), 0.0);
  if (sun_ == "none") {
    addSky(directions, up_, configuration_.number("diffuseIrradiance"), incoming.sky);
    return incoming;
  }
  if (sun_ == "direction") {
    addSun(sunDirection_, configuration_.number("directIrradiance"), incoming);
    addSky(directions, sunDirection_, configuration_.number("diffuseIrradiance"), incoming.sky);
    return incoming;
  }
  const auto samples = static_cast<int>(configuration_.integer("sunSamples"));
  for (int i = 0; i < samples; ++i) {
    const double day = startDay_ + timeDays + stepDays_ * (i + 0.5) / samples;
    const SunPosition position = sunPosition(day, latitude_, longitude_);
    const double sine = core::sin(position.elevationRadians);
    if (sine > 1e-3) {
      const Vec3 direction = sunDirection(position, up_, north_);
      const double passed = core::pow(configuration_.number("atmosphere"), 1.0 / sine);
      const double outside = solarIrradiance(day) / samples;
      addSun(direction, outside * passed, incoming);
      addSky(directions, direction, 0.3 * (1.0 - passed) * outside * sine, incoming.sky);
    }
  }
  return incoming;
}

void Daylight::addSun(const Vec3& direction, double irradiance, Incoming& incoming) const {
  LeafLight::Sun sun{direction, {}};
  for (const double part : configuration_.numbers("bands")) {
    sun.irradiance.push_back(irradiance * part);
  }
  incoming.suns.push_back(std::move(sun));
}

/// Adds a sky that gives a horizontal plane this irradiance, as the directions of each lattice sum it up.
void Daylight::addSky(const RayDirections& directions, const Vec3& sun, double irradiance,
                      std::vector<double>& sky) const {
  std::vector<double> radiance(directions.all().size(), 0.0);
  for (const RayDirections::Lattice& lattice : directions.lattices()) {
    double weights = 0.0;
    double sum = 0.0;
    const std::size_t end = lattice.begin + lattice.count;
    for (std::size_t i = lattice.begin; i < end; ++i) {
      const Vec3& direction = directions.all()[i];
      const double cosine = core::dot(direction, up_);
      if (cosine > 0.0) {
        radiance[i] = skyRadiance(skyKind_, cosine, core::dot(direction, sun), core::dot(up_, sun));
        weights += cosine;
        sum += cosine * radiance[i];
      }
    }
    for (std::size_t i = lattice.begin; i < end; ++i) {
      sky[i] += radiance[i] * irradiance / (pi * sum / weights);
    }
  }
}

}  // namespace espalier::environment

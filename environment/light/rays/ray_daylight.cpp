#include "environment/light/rays/ray_daylight.h"

#include <numbers>
#include <utility>

namespace espalier::environment {

using core::Vec3;
using std::numbers::pi;

namespace {

void addSky(const Daylight::Sky& sky, SkyKind kind, const RayDirections& directions, const Vec3& up,
            RayDaylight& light) {
  light.diffuse += sky.irradiance;
  std::vector<double> radiance(directions.all().size(), 0.0);
  for (const RayDirections::Lattice& lattice : directions.lattices()) {
    double weights = 0.0;
    double sum = 0.0;
    const std::size_t end = lattice.begin + lattice.count;
    for (std::size_t i = lattice.begin; i < end; ++i) {
      const Vec3& direction = directions.all()[i];
      const double cosine = core::dot(direction, up);
      if (cosine > 0.0) {
        radiance[i] = skyRadiance(kind, cosine, core::dot(direction, sky.sun), core::dot(up, sky.sun));
        weights += cosine;
        sum += cosine * radiance[i];
      }
    }
    for (std::size_t i = lattice.begin; i < end; ++i) {
      light.sky[i] += radiance[i] * sky.irradiance / (pi * sum / weights);
    }
  }
}

}  // namespace

RayDaylight onRays(const Daylight::Incoming& incoming, SkyKind kind, const std::vector<double>& parts,
                   const RayDirections& directions, const Vec3& up) {
  RayDaylight light;
  light.sky.assign(directions.all().size(), 0.0);
  for (const Daylight::Sun& sun : incoming.suns) {
    LeafLight::Sun own{sun.direction, {}};
    for (const double part : parts) {
      own.irradiance.push_back(sun.irradiance * part);
    }
    light.suns.push_back(std::move(own));
  }
  for (const Daylight::Sky& sky : incoming.skies) {
    addSky(sky, kind, directions, up, light);
  }
  return light;
}

}  // namespace espalier::environment

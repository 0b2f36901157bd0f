#include "environment/light/rays/plant_surfaces.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

#include "engine/core/elementary.h"
#include "environment/light/sky.h"

namespace espalier::environment {

using core::Vec3;

namespace {

/// A number that goes with a place, the same on machines that round differently: places are told apart to 1/65536, and
/// the border between two such cells is where no model puts anything on purpose.
std::uint32_t seedAt(const Vec3& place) {
  std::uint64_t hash = 0;
  for (const double along : {place.x, place.y, place.z}) {
    const double cell = std::floor(std::clamp(along, -1e12, 1e12) * 65536.0 + 0.377);
    hash = (hash ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(cell))) * 0x9E3779B97F4A7C15ULL;
    hash ^= hash >> 32U;
  }
  return static_cast<std::uint32_t>(hash & 0xFFFFFFU);
}

/// Adds the seeds and the thinning of an organ of so many triangles: together they have the rays of one.
void addRays(const Vec3& place, std::size_t count, LightSurfaces& surfaces) {
  const std::uint32_t seed = seedAt(place);
  for (std::size_t i = 0; i < count; ++i) {
    surfaces.seed.push_back(seed + static_cast<std::uint32_t>(i));
  }
  surfaces.thinning.insert(surfaces.thinning.end(), count, static_cast<std::uint8_t>(std::bit_width(count) - 1));
}

void addSegment(const turtle::Geometry& geometry, std::size_t segment, int sides, PlantSurfaces& plants) {
  const Vec3& start = geometry.start[segment];
  const Vec3& end = geometry.end[segment];
  const Vec3 along = core::normalised(end - start);
  if (core::dot(along, along) == 0.0 || !(geometry.startWidth[segment] + geometry.endWidth[segment] > 0.0)) {
    return;
  }
  const auto [first, second] = horizontalAxes(along);
  // a prism with the circumference of the circle
  const double wider = std::numbers::pi / (sides * core::sin(std::numbers::pi / sides));
  LightSurfaces& surfaces = plants.surfaces;
  const auto base = static_cast<std::uint32_t>(surfaces.vertices.size());
  for (int k = 0; k < sides; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / sides;
    const Vec3 out = (first * core::cos(angle) + second * core::sin(angle)) * (0.5 * wider);
    surfaces.vertices.push_back(start + out * geometry.startWidth[segment]);
    surfaces.vertices.push_back(end + out * geometry.endWidth[segment]);
  }
  addRays(start, 2 * static_cast<std::size_t>(sides), surfaces);
  for (int k = 0; k < sides; ++k) {
    const std::uint32_t here = base + 2 * static_cast<std::uint32_t>(k);
    const std::uint32_t next = base + 2 * static_cast<std::uint32_t>((k + 1) % sides);
    for (const std::array<std::uint32_t, 3>& corners :
         {std::array{here, next, next + 1}, std::array{here, next + 1, here + 1}}) {
      surfaces.triangles.push_back(corners);
      surfaces.material.push_back(PlantSurfaces::kSegment + geometry.segments.colour[segment]);
      plants.sources.emplace_back(geometry.segments.plant[segment], geometry.segments.module[segment]);
    }
  }
}

}  // namespace

std::pair<std::size_t, std::size_t> PlantSurfaces::rangeOf(std::uint32_t plant, std::uint64_t module) const {
  const auto key = std::pair(plant, module);
  const auto begin = std::lower_bound(bySource.begin(), bySource.end(), key,
                                      [&](std::uint32_t triangle, const auto& k) { return sources[triangle] < k; });
  const auto end = std::upper_bound(begin, bySource.end(), key,
                                    [&](const auto& k, std::uint32_t triangle) { return k < sources[triangle]; });
  return {static_cast<std::size_t>(begin - bySource.begin()), static_cast<std::size_t>(end - bySource.begin())};
}

PlantSurfaces surfacesOf(const turtle::Geometry& geometry, int sides) {
  PlantSurfaces plants;
  plants.surfaces.vertices = geometry.vertices;
  plants.surfaces.triangles = geometry.triangles;
  for (std::size_t organ = 0; organ < geometry.organs.size(); ++organ) {
    const std::uint64_t count = geometry.triangleOffset[organ + 1] - geometry.triangleOffset[organ];
    plants.surfaces.material.insert(plants.surfaces.material.end(), count, geometry.organs.colour[organ]);
    if (count > 0) {
      addRays(geometry.vertices[geometry.triangles[geometry.triangleOffset[organ]][0]], count, plants.surfaces);
    }
    plants.sources.insert(plants.sources.end(), count,
                          std::pair(geometry.organs.plant[organ], geometry.organs.module[organ]));
  }
  if (!geometry.areWidthsPixels) {
    for (std::size_t segment = 0; segment < geometry.segments.size(); ++segment) {
      addSegment(geometry, segment, sides, plants);
    }
  }
  plants.bySource.resize(plants.sources.size());
  std::iota(plants.bySource.begin(), plants.bySource.end(), 0U);
  std::sort(plants.bySource.begin(), plants.bySource.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(plants.sources[a], a) < std::pair(plants.sources[b], b);
  });
  return plants;
}

}  // namespace espalier::environment

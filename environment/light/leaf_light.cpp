#include "environment/light/leaf_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>
#include <utility>

namespace espalier::environment {

using core::Vec3;
using std::numbers::pi;

namespace {

double fraction(double x) {
  return x - std::floor(x);
}

}  // namespace

LeafLight::LeafLight(const LightSurfaces& surfaces, std::vector<std::uint32_t> wanted, const std::vector<Sun>& suns,
                     const Options& options)
    : surfaces_(surfaces),
      suns_(suns),
      options_(options),
      directions_(directionsOf(options.directions)),
      caster_(surfaces.vertices, surfaces.triangles, options.repetition, options.threads),
      wanted_(std::move(wanted)) {
  const std::size_t count = surfaces_.triangles.size();
  for (const auto& corners : surfaces_.triangles) {
    const Vec3& a = surfaces_.vertices[corners[0]];
    const Vec3 across = core::cross(surfaces_.vertices[corners[1]] - a, surfaces_.vertices[corners[2]] - a);
    areas_.push_back(0.5 * core::length(across));
    normals_.push_back(core::normalised(across));
  }
  if (wanted_.empty()) {
    for (std::uint32_t triangle = 0; triangle < count; ++triangle) {
      wanted_.push_back(triangle);
    }
  }
  rowOf_.assign(count, RayCaster::kMiss);
  for (std::uint32_t row = 0; row < wanted_.size(); ++row) {
    rowOf_[wanted_[row]] = row;
  }
  hits_.resize(wanted_.size() * directions_.size());
  isLit_.resize(wanted_.size() * suns_.size());
  inParallel(wanted_.size(), [&](std::size_t row) { traceRays(static_cast<std::uint32_t>(row)); });
  rayCount_ = hits_.size() + isLit_.size();
}

std::vector<Vec3> LeafLight::directionsOf(int count) {
  std::vector<Vec3> directions;
  for (int i = 0; i < count; ++i) {
    const double height = 1.0 - (2.0 * i + 1.0) / count;
    const double width = std::sqrt(1.0 - height * height);
    const double angle = i * pi * (3.0 - std::sqrt(5.0));
    directions.push_back({width * std::cos(angle), height, width * std::sin(angle)});
  }
  return directions;
}

template <typename Work>
void LeafLight::inParallel(std::size_t count, const Work& work) const {
  const std::size_t threads = std::clamp<std::size_t>(options_.threads, 1, std::max<std::size_t>(count / 64, 1));
  const auto part = [&](std::size_t number) {
    for (std::size_t i = count * number / threads; i < count * (number + 1) / threads; ++i) {
      work(i);
    }
  };
  std::vector<std::jthread> team;
  for (std::size_t number = 1; number < threads; ++number) {
    team.emplace_back(part, number);
  }
  part(0);
}

Vec3 LeafLight::pointOf(std::uint32_t triangle, std::size_t direction) const {
  // the R2 sequence (Roberts 2018), another part of it for each triangle
  const auto number = static_cast<double>(direction + 1) + 0.6180339887498949 * static_cast<double>(triangle % 8191);
  double u = fraction(0.7548776662466927 * number);
  double v = fraction(0.5698402909980532 * number);
  if (u + v > 1.0) {
    u = 1.0 - u;
    v = 1.0 - v;
  }
  const auto& corners = surfaces_.triangles[triangle];
  const Vec3& a = surfaces_.vertices[corners[0]];
  return a + (surfaces_.vertices[corners[1]] - a) * u + (surfaces_.vertices[corners[2]] - a) * v;
}

void LeafLight::traceRays(std::uint32_t row) {
  const std::uint32_t triangle = wanted_[row];
  const Vec3& normal = normals_[triangle];
  const double margin = 2.0 * caster_.margin();
  std::uint32_t* hits = hits_.data() + static_cast<std::size_t>(row) * directions_.size();
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    const Vec3& direction = directions_[i];
    const double side = core::dot(direction, normal) >= 0.0 ? 1.0 : -1.0;
    const Vec3 start = pointOf(triangle, i) + normal * (side * margin);
    if (!options_.keepsHits) {
      hits[i] = caster_.isFree(start, direction) ? kSky : 0U;
      continue;
    }
    const std::uint32_t hit = caster_.firstHit(start, direction);
    hits[i] = hit == RayCaster::kMiss ? kSky : 2 * hit + (core::dot(normals_[hit], direction) < 0.0 ? 0U : 1U);
  }
  for (std::size_t i = 0; i < suns_.size(); ++i) {
    const Vec3& direction = suns_[i].direction;
    const double side = core::dot(direction, normal) >= 0.0 ? 1.0 : -1.0;
    const Vec3 start = pointOf(triangle, i + directions_.size()) + normal * (side * margin);
    isLit_[static_cast<std::size_t>(row) * suns_.size() + i] = caster_.isFree(start, direction) ? 1 : 0;
  }
}

std::vector<double> LeafLight::irradiances(std::size_t band, const std::vector<double>& sky,
                                           const std::vector<LightMaterial>& materials,
                                           const std::vector<double>& emitted, int bounces) const {
  const std::size_t sides = 2 * surfaces_.triangles.size();
  std::vector<double> total(sides, 0.0);
  std::vector<double> exitance = emitted;  // of the sides, what the next round gathers; empty: nothing
  for (int bounce = 0; bounce <= bounces; ++bounce) {
    std::vector<double> gathered(sides, 0.0);
    inParallel(wanted_.size(), [&](std::size_t row) {
      const std::uint32_t triangle = wanted_[row];
      const std::uint32_t* hits = hits_.data() + row * directions_.size();
      std::array<double, 2> light{};
      std::array<double, 2> weights{};
      for (std::size_t i = 0; i < directions_.size(); ++i) {
        const double cosine = core::dot(directions_[i], normals_[triangle]);
        const std::size_t side = cosine >= 0.0 ? 0 : 1;
        const double weight = std::abs(cosine);
        weights[side] += weight;
        if (hits[i] == kSky) {
          light[side] += bounce == 0 ? weight * sky[i] : 0.0;
        } else if (!exitance.empty()) {
          light[side] += weight * exitance[hits[i]] / pi;
        }
      }
      for (std::size_t side = 0; side < 2; ++side) {
        gathered[2 * triangle + side] = weights[side] > 0.0 ? pi * light[side] / weights[side] : 0.0;
      }
      for (std::size_t i = 0; bounce == 0 && i < suns_.size(); ++i) {
        const double cosine = core::dot(suns_[i].direction, normals_[triangle]);
        if (isLit_[row * suns_.size() + i] != 0) {
          gathered[2 * triangle + (cosine >= 0.0 ? 0U : 1U)] += std::abs(cosine) * suns_[i].irradiance[band];
        }
      }
    });
    exitance.resize(sides);
    for (std::size_t side = 0; side < sides; ++side) {
      total[side] += gathered[side];
      const LightMaterial& material = materials[surfaces_.material[side / 2]];
      exitance[side] = material.reflectance * gathered[side] + material.transmittance * gathered[side ^ 1U];
    }
  }
  return total;
}

double LeafLight::irradianceAt(const Vec3& point, const Vec3& normal, std::size_t band,
                               const std::vector<double>& sky) const {
  double light = 0.0;
  double weights = 0.0;
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    const double cosine = core::dot(directions_[i], normal);
    if (cosine > 0.0) {
      weights += cosine;
      light += caster_.isFree(point, directions_[i]) ? cosine * sky[i] : 0.0;
    }
  }
  double sum = weights > 0.0 ? pi * light / weights : 0.0;
  for (const Sun& sun : suns_) {
    const double cosine = core::dot(sun.direction, normal);
    if (cosine > 0.0 && caster_.isFree(point, sun.direction)) {
      sum += cosine * sun.irradiance[band];
    }
  }
  return sum;
}

}  // namespace espalier::environment

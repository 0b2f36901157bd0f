#include "clients/espalier/rendering/path_tracer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"
#include "environment/light/sky.h"

namespace espalier::command {

using core::Vec3;

namespace {

constexpr int kMostBounces = 8;
constexpr int kMostPassed = 64;  // transparent surfaces on one path
constexpr int kBouncesWithoutChance = 2;
constexpr double kGroundAlbedo = 0.35;
constexpr double kPlantAlbedo = 0.15;  // of what hides the sky from the ground
constexpr double kBrightest = 6.0;     // of one sample: rarer, brighter paths are noise

std::uint64_t scrambled(std::uint64_t x) {
  // splitmix64 (Steele et al. 2014)
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

double fraction(std::uint64_t bits) {
  return static_cast<double>(bits >> 11U) * 0x1p-53;
}

double brightness(const Light& light) {
  return 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
}

Light product(const Light& a, const Light& b) {
  return {a[0] * b[0], a[1] * b[1], a[2] * b[2]};
}

void add(Light& sum, const Light& light, double factor) {
  for (std::size_t k = 0; k < 3; ++k) {
    sum[k] += factor * light[k];
  }
}

// a direction about a unit vector, as likely as its cosine
Vec3 diffuseDirection(const Vec3& normal, SampleNumbers& numbers) {
  const auto [first, second] = environment::horizontalAxes(normal);
  const double radius = std::sqrt(numbers.next());
  const double turn = 2.0 * std::numbers::pi * numbers.next();
  const double height = std::sqrt(std::max(0.0, 1.0 - radius * radius));
  return core::normalised(radius * core::cos(turn) * first + radius * core::sin(turn) * second + height * normal);
}

}  // namespace

double SampleNumbers::next() {
  // fractions of the square roots of primes
  constexpr std::array<double, 10> kSteps{
      0.41421356237309503, 0.73205080756887729, 0.23606797749978969, 0.64575131106459059, 0.31662479035539985,
      0.60555127546398929, 0.12310562561766053, 0.35889894354067355, 0.79583152331271956, 0.38516480713450403};
  const std::uint64_t key = scrambled(pixel_ * 64 + dimension_);
  const std::uint32_t dimension = dimension_++;
  if (dimension >= kSteps.size()) {
    return fraction(scrambled(key ^ sample_ * 0x2545F4914F6CDD1DULL));
  }
  const double value = fraction(key) + (sample_ + 1.0) * kSteps[dimension];
  return value - std::floor(value);
}

std::optional<Vec3> PathTracer::groundOn(const Vec3& origin, const Vec3& direction) const {
  if (!ground_ || direction.y > -1e-6 || origin.y <= *ground_) {
    return std::nullopt;
  }
  return origin + (*ground_ - origin.y) / direction.y * direction;
}

double PathTracer::shadeOf(const Vec3& place, SampleNumbers& numbers) const {
  const double sun = scene_.arriving(place, daylight_.towardSun(numbers.next(), numbers.next()));
  const double sky = scene_.arriving(place, diffuseDirection({0.0, 1.0, 0.0}, numbers));
  const double share = brightness(daylight_.sunOnGround());
  return share * sun + (1.0 - share) * (kPlantAlbedo + (1.0 - kPlantAlbedo) * sky);
}

Light PathTracer::outside(const Vec3& origin, const Vec3& direction, SampleNumbers& numbers) const {
  if (const auto ground = groundOn(origin, direction)) {
    const double seen = kGroundAlbedo * shadeOf(*ground, numbers);
    return {seen, seen, seen};
  }
  return daylight_.sky(direction);
}

void PathTracer::addSun(const Meeting& met, const Vec3& towardViewer, const Light& share, SampleNumbers& numbers,
                        Light& light) const {
  const Vec3 towardSun = daylight_.towardSun(numbers.next(), numbers.next());
  const double cosine = core::dot(met.normal, towardSun);
  const bool isBehind = cosine < 0.0;
  const Light& part = isBehind ? met.paint.letThrough : met.paint.thrownBack;
  if (brightness(part) == 0.0 && (isBehind || brightness(met.paint.shine) == 0.0)) {
    return;
  }
  const double arriving = scene_.arriving(met.place, towardSun);
  if (arriving == 0.0) {
    return;
  }
  const Light sun = product(share, daylight_.sun());
  add(light, product(sun, part), arriving * std::abs(cosine));
  if (!isBehind) {
    const double mirrored = std::max(0.0, core::dot(met.normal, core::normalised(towardSun + towardViewer)));
    add(light, product(sun, met.paint.shine), arriving * core::pow(mirrored, met.paint.shininess));
  }
}

Seen PathTracer::look(Vec3 origin, Vec3 direction, SampleNumbers& numbers) const {
  Seen seen;
  Light share{1.0, 1.0, 1.0};
  int passed = 0;
  for (int bounce = 0; bounce < kMostBounces;) {
    const std::optional<Meeting> met = scene_.meet(origin, direction);
    if (!met) {
      if (bounce > 0) {
        add(seen.light, product(share, outside(origin, direction, numbers)), 1.0);
      } else if (const auto ground = groundOn(origin, direction)) {
        seen.shade = shadeOf(*ground, numbers);
      }
      break;
    }
    const Paint& paint = met->paint;
    if (paint.opacity < 1.0 && numbers.next() >= paint.opacity) {
      if (++passed > kMostPassed) {
        break;
      }
      origin = met->place;
      continue;
    }
    seen.isPlant = true;
    add(seen.light, product(share, paint.emitted), 1.0);
    addSun(*met, -direction, share, numbers, seen.light);

    // follow what is thrown back or what comes through, by chance as strong as they are
    const double back = brightness(paint.thrownBack);
    const double through = brightness(paint.letThrough);
    if (back + through <= 0.0) {
      break;
    }
    const bool isThrownBack = numbers.next() * (back + through) < back;
    share = product(share, isThrownBack ? paint.thrownBack : paint.letThrough);
    const double chance = (isThrownBack ? back : through) / (back + through);
    for (double& part : share) {
      part /= chance;
    }
    if (++bounce > kBouncesWithoutChance) {
      const double survival = std::min(0.95, std::max({share[0], share[1], share[2]}));
      if (numbers.next() >= survival) {
        break;
      }
      for (double& part : share) {
        part /= survival;
      }
    }
    origin = met->place;
    direction = diffuseDirection(isThrownBack ? met->normal : -met->normal, numbers);
  }
  for (double& part : seen.light) {
    part = std::min(part, kBrightest);
  }
  return seen;
}

}  // namespace espalier::command

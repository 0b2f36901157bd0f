#include "environment/light/rays/leaf_light.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "engine/core/check.h"
#include "engine/core/work_meter.h"
#include "engine/core/worker_team.h"

namespace espalier::environment {

using core::Vec3;
using std::numbers::pi;

namespace {

/// Of a number that is not negative.
double fraction(double x) {
  return x - static_cast<double>(static_cast<std::int64_t>(x));
}

/// Every third bit of a number, of ten bits.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16U) & 0x030000FFU;
  x = (x | x << 8U) & 0x0300F00FU;
  x = (x | x << 4U) & 0x030C30C3U;
  return (x | x << 2U) & 0x09249249U;
}

}  // namespace

/// Where the rays of a triangle start: at points of it that the R2 sequence (Roberts 2018) gives, another part of it
/// for each triangle, and a little off it towards where they go.
class RayStarts {
 public:
  RayStarts(const LightSurfaces& surfaces, std::uint32_t triangle, const Vec3& normal, double margin)
      : corner_(surfaces.vertices[surfaces.triangles[triangle][0]]),
        first_(surfaces.vertices[surfaces.triangles[triangle][1]] - corner_),
        second_(surfaces.vertices[surfaces.triangles[triangle][2]] - corner_),
        normal_(normal),
        off_(normal * (2.0 * margin)),
        place_(1.0 + 0.6180339887498949 * static_cast<double>(surfaces.seedOf(triangle) % 8191)) {}

  [[nodiscard]] Vec3 of(std::size_t number, const Vec3& direction) const {
    const double place = place_ + static_cast<double>(number);
    double u = fraction(0.7548776662466927 * place);
    double v = fraction(0.5698402909980532 * place);
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    const Vec3 point = corner_ + first_ * u + second_ * v;
    return core::dot(direction, normal_) >= 0.0 ? point + off_ : point - off_;
  }

 private:
  Vec3 corner_, first_, second_;  // of the triangle, and from there to the others
  Vec3 normal_;
  Vec3 off_;
  double place_;
};

/// The rays of the scene before, and what changed since.
struct LeafLight::Earlier {
  SurfaceChanges changes;
  RayCaster changed;  // triangles that came or went
  std::vector<std::uint32_t> rowOf;
  std::vector<std::size_t> rowStart;
  std::vector<std::uint32_t> hits;
  std::vector<std::uint8_t> isLit;
  std::size_t sunCount = 0;
  std::vector<bool> isSameSun;  // (suns)
};

LeafLight::LeafLight(const Options& options)
    : options_(options),
      directions_(options.directions),
      caster_({}, {}, options.repetition, {}, options.threads),
      rowStart_{0} {}

LeafLight::LeafLight(LightSurfaces surfaces, std::vector<std::uint32_t> wanted, std::vector<Sun> suns,
                     const Options& options)
    : LeafLight(options) {
  setScene(std::move(surfaces), std::move(wanted), std::move(suns));
}

void LeafLight::setScene(LightSurfaces surfaces, std::vector<std::uint32_t> wanted, std::vector<Sun> suns) {
  const std::size_t count = surfaces.triangles.size();
  ESPALIER_CHECK(surfaces.material.size() == count);
  ESPALIER_CHECK(surfaces.seed.empty() || surfaces.seed.size() == count);
  ESPALIER_CHECK(surfaces.thinning.empty() || surfaces.thinning.size() == count);
  // the rays that the last scene can give
  SurfaceChanges changes = changesBetween(surfaces_, surfaces);
  const bool isSameScene = changes.isEmpty() && !surfaces.triangles.empty();
  const bool isMostlyKept = 2 * changes.changed.triangles.size() < surfaces.triangles.size();
  const double margin = caster_.margin();
  const Vec3 middle = caster_.middle();
  std::swap(surfaces_, surfaces);
  if (!isSameScene) {
    caster_ = RayCaster(surfaces_.vertices, surfaces_.triangles, options_.repetition,
                        RayCaster::middleOf(surfaces_.vertices), options_.threads);
    measure();
  }
  std::optional<Earlier> earlier;
  // in a plot that repeats itself all rays have the same margin
  if (isMostlyKept && caster_.middle() == middle && (!options_.repetition || caster_.margin() == margin)) {
    earlier.emplace(
        Earlier{{},
                RayCaster(changes.changed.vertices, changes.changed.triangles, options_.repetition, middle, 1),
                std::move(rowOf_),
                std::move(rowStart_),
                std::move(hits_),
                std::move(isLit_),
                suns_.size(),
                {}});
    earlier->changes = std::move(changes);
    for (std::size_t i = 0; i < suns.size(); ++i) {
      earlier->isSameSun.push_back(i < suns_.size() && suns_[i].direction == suns[i].direction);
    }
  }
  suns_ = std::move(suns);
  listRows(std::move(wanted));
  // neighbours in space one after the other: they meet the same triangles, which are still in the caches
  const std::vector<std::uint32_t> order = rowsInSpace();
  std::atomic<std::uint64_t> kept = 0;
  inParallel(order.size(), [&](std::size_t i) {
    const std::uint64_t more = traceRow(order[i], earlier ? &*earlier : nullptr);
    if (more != 0) {
      kept.fetch_add(more, std::memory_order_relaxed);
    }
  });
  keptCount_ = kept;
}

void LeafLight::measure() {
  areas_.clear();
  normals_.clear();
  for (const auto& corners : surfaces_.triangles) {
    const Vec3& a = surfaces_.vertices[corners[0]];
    const Vec3 across = core::cross(surfaces_.vertices[corners[1]] - a, surfaces_.vertices[corners[2]] - a);
    areas_.push_back(0.5 * core::length(across));
    normals_.push_back(core::normalised(across));
  }
}

RayDirections::Lattice LeafLight::gatheringOf(std::uint32_t triangle) const {
  return directions_.latticeOf(surfaces_.thinningOf(triangle), surfaces_.seedOf(triangle));
}

RayDirections::Lattice LeafLight::sendingOf(std::uint32_t triangle) const {
  if (!options_.settles) {
    return {};
  }
  const unsigned thinning = surfaces_.thinningOf(triangle);
  return triangle < surfaces_.groundBegin ? directions_.otherLatticeOf(thinning, surfaces_.seedOf(triangle))
                                          : directions_.allLatticesOf(thinning);
}

void LeafLight::listRows(std::vector<std::uint32_t> wanted) {
  const std::size_t count = surfaces_.triangles.size();
  wanted_ = std::move(wanted);
  if (wanted_.empty()) {
    wanted_.resize(count);
    std::iota(wanted_.begin(), wanted_.end(), 0U);
  }
  rowOf_.assign(count, RayCaster::kMiss);
  rowStart_.assign(1, 0);
  for (std::uint32_t row = 0; row < wanted_.size(); ++row) {
    const std::uint32_t triangle = wanted_[row];
    rowOf_[triangle] = row;
    rowStart_.push_back(rowStart_.back() + gatheringOf(triangle).count + sendingOf(triangle).count);
  }
  hits_.assign(rowStart_.back(), kSky);
  isLit_.assign(wanted_.size() * suns_.size(), 0);
}

std::vector<std::uint32_t> LeafLight::rowsInSpace() const {
  // along the Z-order curve (Morton 1966) of 1024 cells in each direction
  Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL};
  Vec3 high = low * -1.0;
  for (const Vec3& vertex : surfaces_.vertices) {
    low = {std::min(low.x, vertex.x), std::min(low.y, vertex.y), std::min(low.z, vertex.z)};
    high = {std::max(high.x, vertex.x), std::max(high.y, vertex.y), std::max(high.z, vertex.z)};
  }
  const double widest = std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-300});
  const auto cellOf = [&](double along) { return spread(static_cast<std::uint32_t>(1023.0 * (along / widest))); };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> rows;
  rows.reserve(wanted_.size());
  for (std::uint32_t row = 0; row < wanted_.size(); ++row) {
    const Vec3 place = surfaces_.vertices[surfaces_.triangles[wanted_[row]][0]] - low;
    rows.emplace_back(cellOf(place.x) | cellOf(place.y) << 1U | cellOf(place.z) << 2U, row);
  }
  std::sort(rows.begin(), rows.end());
  std::vector<std::uint32_t> order;
  order.reserve(rows.size());
  for (const auto& entry : rows) {
    order.push_back(entry.second);
  }
  return order;
}

template <typename Work>
void LeafLight::inParallel(std::size_t count, const Work& work) const {
  constexpr std::size_t kBlock = 256;
  const std::size_t threads = std::clamp<std::size_t>(count / kBlock, 1, std::max(options_.threads, 1U));
  core::WorkerTeam team(static_cast<unsigned>(threads));
  team.forEach((count + kBlock - 1) / kBlock, [&](std::size_t block) {
    core::pollWork();
    for (std::size_t i = block * kBlock; i < std::min((block + 1) * kBlock, count); ++i) {
      work(i);
    }
  });
}

std::uint64_t LeafLight::traceRow(std::uint32_t row, const Earlier* earlier) {
  const std::uint32_t triangle = wanted_[row];
  const double margin = caster_.marginOf(triangle);
  const RayStarts starts(surfaces_, triangle, normals_[triangle], margin);
  // the row of the same triangle in the scene before
  std::uint32_t before = RayCaster::kMiss;
  if (earlier != nullptr && earlier->changes.earlierOf[triangle] != SurfaceChanges::kNone) {
    before = earlier->rowOf[earlier->changes.earlierOf[triangle]];
  }
  const auto isKept = [&](const Vec3& start, const Vec3& direction) {
    return earlier->changes.isEmpty() || earlier->changed.isFree(start, direction, margin);
  };
  std::uint64_t kept = 0;
  const auto gathering = gatheringOf(triangle);
  const auto sending = sendingOf(triangle);
  const std::size_t count = gathering.count + sending.count;
  std::uint32_t* hits = hits_.data() + rowStart_[row];
  const bool isRowKept = before != RayCaster::kMiss && earlier->changes.isEmpty();
  if (isRowKept) {
    std::copy_n(earlier->hits.data() + earlier->rowStart[before], count, hits);
    kept += count;
  }
  for (std::size_t i = isRowKept ? count : 0; i < count; ++i) {
    const bool isGathering = i < gathering.count;
    const bool hasHit = isGathering ? gathersFromSurfaces(triangle) : true;
    const Vec3& direction = directions_.all()[isGathering ? gathering.begin + i : sending.begin + i - gathering.count];
    const Vec3 start = starts.of(i, direction);
    if (before != RayCaster::kMiss && isKept(start, direction)) {
      const std::uint32_t hit = earlier->hits[earlier->rowStart[before] + i];
      ESPALIER_CHECK(hit == kSky || !hasHit || earlier->changes.laterOf[hit / 2] != SurfaceChanges::kNone);
      hits[i] = hit == kSky || !hasHit ? hit : 2 * earlier->changes.laterOf[hit / 2] + hit % 2;
      ++kept;
    } else if (!hasHit) {
      hits[i] = caster_.isFree(start, direction, margin) ? kSky : 0U;
    } else {
      const RayCaster::Hit hit = caster_.firstHit(start, direction, margin);
      hits[i] = hit.triangle == RayCaster::kMiss ? kSky : 2 * hit.triangle + (hit.isFront ? 0U : 1U);
    }
  }
  for (std::size_t i = 0; i < suns_.size(); ++i) {
    const Vec3& direction = suns_[i].direction;
    const Vec3 start = starts.of(i + count, direction);
    std::uint8_t& isLit = isLit_[static_cast<std::size_t>(row) * suns_.size() + i];
    if (before != RayCaster::kMiss && earlier->isSameSun[i] && isKept(start, direction)) {
      isLit = earlier->isLit[before * earlier->sunCount + i];
      ++kept;
    } else {
      isLit = caster_.isFree(start, direction, margin) ? 1 : 0;
    }
  }
  return kept;
}

std::vector<double> LeafLight::irradiances(std::size_t band, const std::vector<double>& sky,
                                           const std::vector<LightMaterial>& materials,
                                           const std::vector<double>& emitted, int bounces,
                                           std::vector<double>* sent) const {
  const std::size_t sides = 2 * surfaces_.triangles.size();
  std::vector<double> total(sides, 0.0);
  if (sent != nullptr) {
    sent->assign(sides, 0.0);
  }
  std::vector<double> exitance = emitted;  // of the sides, for the next round; empty: none
  for (int bounce = 0; bounce <= bounces; ++bounce) {
    std::vector<double> gathered(sides, 0.0);
    for (std::size_t side = 0; sent != nullptr && side < exitance.size(); ++side) {
      (*sent)[side] += exitance[side];
    }
    inParallel(wanted_.size(), [&](std::size_t row) {
      const std::uint32_t triangle = wanted_[row];
      const std::uint32_t* hits = hits_.data() + rowStart_[row];
      const auto lattice = gatheringOf(triangle);
      std::array<double, 2> light{};
      std::array<double, 2> weights{};
      for (std::size_t i = 0; i < lattice.count; ++i) {
        const double cosine = core::dot(directions_.all()[lattice.begin + i], normals_[triangle]);
        const std::size_t side = cosine >= 0.0 ? 0 : 1;
        const double weight = std::abs(cosine);
        weights[side] += weight;
        if (hits[i] == kSky) {
          light[side] += bounce == 0 ? weight * sky[lattice.begin + i] : 0.0;
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

double LeafLight::irradianceAt(const Vec3& point, const Vec3& normal, std::size_t band, const std::vector<double>& sky,
                               const std::vector<double>& sent) const {
  // a sensor may lie on a surface
  const double margin = caster_.margin();
  double light = 0.0;
  double weights = 0.0;
  const RayDirections::Lattice lattice = directions_.latticeOf(0, 0);
  for (std::size_t i = lattice.begin; i < lattice.begin + lattice.count; ++i) {
    const Vec3& direction = directions_.all()[i];
    const double cosine = core::dot(direction, normal);
    if (cosine > 0.0) {
      weights += cosine;
      if (sent.empty()) {
        light += caster_.isFree(point, direction, margin) ? cosine * sky[i] : 0.0;
        continue;
      }
      const RayCaster::Hit hit = caster_.firstHit(point, direction, margin);
      light += cosine * (hit.triangle == RayCaster::kMiss
                             ? sky[i]
                             : sent[2 * std::size_t{hit.triangle} + (hit.isFront ? 0U : 1U)] / pi);
    }
  }
  double sum = weights > 0.0 ? pi * light / weights : 0.0;
  for (const Sun& sun : suns_) {
    const double cosine = core::dot(sun.direction, normal);
    if (cosine > 0.0 && caster_.isFree(point, sun.direction, margin)) {
      sum += cosine * sun.irradiance[band];
    }
  }
  return sum;
}

}  // namespace espalier::environment

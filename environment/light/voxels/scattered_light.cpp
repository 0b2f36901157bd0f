#include "environment/light/voxels/scattered_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/core/elementary.h"
#include "environment/light/sky.h"

namespace espalier::environment {

using core::Vec3;
using std::numbers::pi;

namespace {

constexpr int kMostOrders = 100'000;
constexpr std::uint32_t kBare = std::numeric_limits<std::uint32_t>::max();

/// (1 − e^−x)/x, also where x is tiny.
double meanOfDecay(double x) {
  return x < 1e-8 ? 1.0 - 0.5 * x : -core::expm1(-x) / x;
}

}  // namespace

ScatteredLight::ScatteredLight(const VoxelField& field, const Options& options, const Vec3& up,
                               std::span<const Beam> beams)
    : field_(field),
      options_(options),
      isPeriodic_(field.shape().isPeriodic),
      counts_(field.counts()),
      voxelSize_(field.shape().voxelSize) {
  makeNormals(up);
  makeDirections(up);
  const std::size_t voxels = field_.values().size();
  leafyOf_.assign(voxels, kBare);
  for (std::size_t voxel = 0; voxel < voxels; ++voxel) {
    if (field_.values()[voxel] > 0.0) {
      leafyOf_[voxel] = static_cast<std::uint32_t>(leafyVoxels_.size());
      leafyVoxels_.push_back(static_cast<std::uint32_t>(voxel));
    }
  }
  const auto columns = static_cast<std::size_t>(counts_[0] * counts_[1]);
  taken_.assign(leafyVoxels_.size() * normals_.size() * 2, 0.0);
  emitted_.assign(taken_.size(), 0.0);
  absorbed_.assign(leafyVoxels_.size(), 0.0);
  source_.assign(voxels, 0.0);
  mean_.assign(voxels, 0.0);
  down_.assign(voxels, 0.0);
  ground_.assign(columns, 0.0);
  groundSource_.assign(columns, 0.0);
  const double column = 1.0 / static_cast<double>(columns);
  // the light that no leaf has met
  for (const Beam& beam : beams) {
    Direction direction;
    direction.towards = beam.direction * -1.0;
    direction.cosine = core::dot(beam.direction, up);
    direction.weight = 1.0;
    direction.pieces = piecesOf(direction.towards);
    const double radiance = beam.irradiance / direction.cosine;
    fluxes_.incoming += beam.irradiance;
    double entered = 0.0;
    double left = 0.0;
    follow(
        direction, beam.projection, [&](std::size_t) { return radiance; }, radiance, false,
        [&](std::size_t at, double rest, bool isAside) {
          if (isAside) {
            entered += radiance;
            left += rest;
          } else {
            ground_[at] += rest * direction.cosine;
          }
        });
    // through the sides as much comes in as the open sky sends there
    fluxes_.incoming += entered * direction.cosine * column;
    fluxes_.aside += left * direction.cosine * column;
    double projection = 0.0;
    for (const Normal& normal : normals_) {
      projection += normal.part * std::abs(core::dot(direction.towards, normal.direction));
    }
    takeUp(direction, projection > 0.0 ? beam.projection / projection : 0.0);
  }
  const double enough = options_.remainder * fluxes_.incoming;
  double rest = scatter();
  std::fill(absorbed_.begin(), absorbed_.end(), 0.0);  // the caller knows the light of the first order exactly
  for (int order = 0; order < kMostOrders && rest > enough; ++order) {
    for (const Direction& direction : directions_) {
      const bool isDown = core::dot(direction.towards, up) < 0.0;
      for (std::size_t i = 0; i < leafyVoxels_.size(); ++i) {
        double sum = 0.0;
        const double* emitted = emitted_.data() + i * normals_.size() * 2;
        for (const Normal& normal : normals_) {
          const double cosine = core::dot(direction.towards, normal.direction);
          const std::size_t side = cosine >= 0.0 ? 0 : 1;
          sum += normal.part * std::abs(cosine) * emitted[side] / normal.emission[side];
          emitted += 2;
        }
        source_[leafyVoxels_[i]] = sum;
      }
      follow(
          direction, direction.projection, [&](std::size_t at) { return isDown ? 0.0 : groundSource_[at] / pi; }, 0.0,
          true,
          [&](std::size_t at, double radiance, bool isAside) {
            const double flux = radiance * direction.cosine * direction.weight;
            if (isAside) {
              fluxes_.aside += flux * column;
            } else if (isDown) {
              ground_[at] += flux;
            } else {
              fluxes_.up += flux * column;
            }
          });
      if (isDown) {
        for (std::size_t voxel = 0; voxel < down_.size(); ++voxel) {
          down_[voxel] += mean_[voxel] * direction.cosine * direction.weight;
        }
      }
      takeUp(direction, 1.0);
    }
    rest = scatter();
  }
}

double ScatteredLight::absorbedAt(std::size_t voxel) const {
  return leafyOf_[voxel] == kBare ? 0.0 : absorbed_[leafyOf_[voxel]];
}

void ScatteredLight::makeNormals(const Vec3& up) {
  const auto [first, second] = horizontalAxes(up);
  for (const LeafNormals& ring : leafNormals(options_.leafAngles, options_.ellipsoidRatio)) {
    const double sine = std::sqrt(std::max(0.0, 1.0 - ring.cosine * ring.cosine));
    const int count = sine > 0.0 ? 8 : 1;
    for (int k = 0; k < count; ++k) {
      const double azimuth = 2.0 * pi * (k + 0.5) / count;
      normals_.push_back({up * ring.cosine + first * (sine * core::cos(azimuth)) + second * (sine * core::sin(azimuth)),
                          ring.part / count,
                          {}});
    }
  }
}

void ScatteredLight::makeDirections(const Vec3& up) {
  for (const LightDirection& light :
       skyRings(SkyKind::Uniform, options_.zenithAngles, options_.azimuthAngles, up, up)) {
    for (const double sign : {-1.0, 1.0}) {
      Direction direction;
      direction.cosine = core::dot(light.direction, up);
      direction.towards = light.direction * sign;
      // a uniform sky gives parts of the irradiance, L cos θ dω/π L
      direction.weight = light.weight * pi / direction.cosine;
      direction.pieces = piecesOf(direction.towards);
      directions_.push_back(std::move(direction));
    }
  }
  for (Direction& direction : directions_) {
    for (Normal& normal : normals_) {
      const double cosine = core::dot(direction.towards, normal.direction);
      direction.projection += normal.part * std::abs(cosine);
      normal.emission[cosine >= 0.0 ? 0 : 1] += direction.weight * std::abs(cosine);
    }
  }
}

std::vector<ScatteredLight::Piece> ScatteredLight::piecesOf(const Vec3& towards) const {
  // from the middle of a column's end to the other end of the box, in voxels
  const std::array<double, 3> way = field_.toOwn(towards);
  std::array<double, 3> place{0.5, 0.5, way[2] < 0.0 ? static_cast<double>(counts_[2]) : 0.0};
  std::array<std::int64_t, 3> cell{0, 0, way[2] < 0.0 ? counts_[2] - 1 : 0};
  std::array<double, 3> next{};
  std::array<double, 3> width{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double border = static_cast<double>(cell[k]) + (way[k] > 0.0 ? 1.0 : 0.0);
    next[k] = way[k] == 0.0 ? std::numeric_limits<double>::infinity() : (border - place[k]) / way[k];
    width[k] = way[k] == 0.0 ? 0.0 : 1.0 / std::abs(way[k]);
  }
  std::vector<Piece> pieces;
  double passed = 0.0;
  while (cell[2] >= 0 && cell[2] < counts_[2]) {
    const std::size_t k = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
    pieces.push_back({cell[0], cell[1], cell[2], (next[k] - passed) * voxelSize_});
    passed = next[k];
    next[k] += width[k];
    cell[k] += way[k] > 0.0 ? 1 : -1;
  }
  return pieces;
}

template <typename Entering, typename Leave>
void ScatteredLight::follow(const Direction& direction, double projection, const Entering& entering, double outside,
                            bool hasSources, const Leave& leave) {
  std::fill(mean_.begin(), mean_.end(), 0.0);
  const double whole = voxelSize_ / direction.cosine;  // length of all rays in a voxel
  const std::vector<double>& densities = field_.values();
  const auto wrapped = [](std::int64_t value, std::int64_t count) {
    const std::int64_t rest = value % count;
    return rest < 0 ? rest + count : rest;
  };
  // rays side by side take the same way: piece by piece for all of them
  const auto columns = static_cast<std::size_t>(counts_[0] * counts_[1]);
  std::vector<double> radiance(columns);
  for (std::size_t at = 0; at < columns; ++at) {
    radiance[at] = entering(at);
  }
  std::int64_t beforeA = 0;
  std::int64_t beforeB = 0;
  for (const Piece& piece : direction.pieces) {
    const double part = piece.length / whole;
    for (std::int64_t a = 0; a < counts_[0]; ++a) {
      const std::int64_t ownA = wrapped(a + piece.a, counts_[0]);
      // the step over the side of the box
      const bool crossesA = !isPeriodic_ && (a + piece.a - ownA) != (a + beforeA - wrapped(a + beforeA, counts_[0]));
      std::int64_t ownB = wrapped(piece.b, counts_[1]);
      const std::size_t row = static_cast<std::size_t>((piece.layer * counts_[0] + ownA) * counts_[1]);
      double* ray = radiance.data() + a * counts_[1];
      for (std::int64_t b = 0; b < counts_[1]; ++b, ++ray) {
        if (!isPeriodic_ && (crossesA || (b + piece.b - ownB) != (b + beforeB - wrapped(b + beforeB, counts_[1])))) {
          leave(static_cast<std::size_t>(a * counts_[1] + b), *ray, true);
          *ray = outside;
        }
        const std::size_t voxel = row + static_cast<std::size_t>(ownB);
        const double density = densities[voxel];
        if (density > 0.0) {
          const double depth = projection * density * piece.length;
          const double source = hasSources && projection > 0.0 ? source_[voxel] / projection : 0.0;
          const double decay = meanOfDecay(depth);
          mean_[voxel] += (source + (*ray - source) * decay) * part;
          *ray += (source - *ray) * decay * depth;
        } else {
          mean_[voxel] += *ray * part;
        }
        ownB = ownB + 1 == counts_[1] ? 0 : ownB + 1;
      }
    }
    beforeA = piece.a;
    beforeB = piece.b;
  }
  // the ends, which lie in other columns than the starts
  for (std::int64_t a = 0; a < counts_[0]; ++a) {
    for (std::int64_t b = 0; b < counts_[1]; ++b) {
      const std::int64_t at = wrapped(a + beforeA, counts_[0]) * counts_[1] + wrapped(b + beforeB, counts_[1]);
      leave(static_cast<std::size_t>(at), radiance[static_cast<std::size_t>(a * counts_[1] + b)], false);
    }
  }
}

void ScatteredLight::takeUp(const Direction& direction, double scale) {
  for (std::size_t i = 0; i < leafyVoxels_.size(); ++i) {
    const double light = mean_[leafyVoxels_[i]] * direction.weight * scale;
    double* taken = taken_.data() + i * normals_.size() * 2;
    for (const Normal& normal : normals_) {
      // light falls on the side that it goes against
      const double cosine = core::dot(direction.towards, normal.direction);
      taken[cosine >= 0.0 ? 1 : 0] += light * std::abs(cosine);
      taken += 2;
    }
  }
}

double ScatteredLight::scatter() {
  const double columns = static_cast<double>(counts_[0] * counts_[1]);
  const double absorptance = 1.0 - options_.reflectance - options_.transmittance;
  double rest = 0.0;
  for (std::size_t i = 0; i < leafyVoxels_.size(); ++i) {
    const double area = field_.values()[leafyVoxels_[i]] * voxelSize_ / columns;
    double* taken = taken_.data() + i * normals_.size() * 2;
    double* emitted = emitted_.data() + i * normals_.size() * 2;
    double met = 0.0;
    for (const Normal& normal : normals_) {
      for (std::size_t side = 0; side < 2; ++side) {
        emitted[side] = options_.reflectance * taken[side] + options_.transmittance * taken[side ^ 1U];
      }
      met += normal.part * (taken[0] + taken[1]);
      taken[0] = 0.0;
      taken[1] = 0.0;
      taken += 2;
      emitted += 2;
    }
    absorbed_[i] += met * absorptance;
    fluxes_.byPlants += met * absorptance * area;
    rest += met * (1.0 - absorptance) * area;
  }
  for (std::size_t column = 0; column < ground_.size(); ++column) {
    fluxes_.down += ground_[column] / columns;
    fluxes_.byGround += ground_[column] * (1.0 - options_.groundReflectance) / columns;
    groundSource_[column] = ground_[column] * options_.groundReflectance;
    rest += groundSource_[column] / columns;
    ground_[column] = 0.0;
  }
  return rest;
}

}  // namespace espalier::environment

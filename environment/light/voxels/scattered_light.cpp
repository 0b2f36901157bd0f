#include "environment/light/voxels/scattered_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"
#include "environment/light/sky.h"

namespace espalier::environment {

using core::Vec3;
using std::numbers::pi;

namespace {

constexpr int kMostOrders = 100'000;
constexpr std::size_t kScatterBlock = 8;   // leafy voxels that are scattered together
constexpr std::size_t kBeamsAtATime = 16;  // whose light in all leafy voxels is in memory

/// (1 − e^−x)/x, also where x is tiny.
double meanOfDecay(double x) {
  return x < 1e-8 ? 1.0 - 0.5 * x : -core::expm1(-x) / x;
}

std::int64_t inBox(std::int64_t value, std::int64_t count) {
  const std::int64_t rest = value % count;
  return rest < 0 ? rest + count : rest;
}

constexpr auto kNobody = [](std::size_t, const double*, std::int64_t, double) {};

}  // namespace

ScatteredLight::ScatteredLight(const VoxelField& field, const Options& options, const Vec3& up,
                               std::span<const Beam> beams)
    : field_(field), options_(options), counts_(field.counts()), voxelSize_(field.shape().voxelSize) {
  makeNormals(up);
  makeDirections(up);
  listLeaves();
  const auto columns = static_cast<std::size_t>(counts_[0] * counts_[1]);
  const std::size_t pairs = directions_.size() / 2;
  sources_.assign(2 * pairs * stride_, 0.0);
  allSources_.assign(pairs * stride_, 0.0);
  absorbed_.assign(stride_, 0.0);
  ground_.assign(columns, 0.0);
  groundSource_.assign(columns, 0.0);
  double rest = scatter(takeBeams(beams, up));
  const double enough = options_.remainder * fluxes_.incoming;
  for (int order = 0; order < kMostOrders && rest > enough; ++order) {
    rest = scatter(sendOut());
  }
  fillDown();
  // of several bands only the light stays in memory
  sources_ = std::vector<double>();
  allSources_ = std::vector<double>();
  directions_ = std::vector<Direction>();
  exchange_ = Exchange();
}

double ScatteredLight::absorbedAt(std::size_t voxel) const {
  const auto place = std::lower_bound(leafyVoxels_.begin(), leafyVoxels_.end(), voxel);
  return place == leafyVoxels_.end() || *place != voxel
             ? 0.0
             : absorbed_[static_cast<std::size_t>(place - leafyVoxels_.begin())];
}

void ScatteredLight::makeNormals(const Vec3& up) {
  const auto [first, second] = horizontalAxes(up);
  for (const LeafNormals& ring : leafNormals(options_.leafAngles, options_.ellipsoidRatio)) {
    const double sine = std::sqrt(std::max(0.0, 1.0 - ring.cosine * ring.cosine));
    const int count = sine > 0.0 ? 8 : 1;
    for (int k = 0; k < count; ++k) {
      const double azimuth = 2.0 * pi * (k + 0.5) / count;
      normals_.push_back({up * ring.cosine + first * (sine * core::cos(azimuth)) + second * (sine * core::sin(azimuth)),
                          ring.part / count, 0.0});
    }
  }
}

void ScatteredLight::makeDirections(const Vec3& up) {
  std::vector<Vec3> towards;
  std::vector<double> weights;
  for (const LightDirection& light :
       skyRings(SkyKind::Uniform, options_.zenithAngles, options_.azimuthAngles, up, up)) {
    for (const double sign : {-1.0, 1.0}) {
      Direction direction;
      direction.cosine = core::dot(light.direction, up);
      direction.towards = light.direction * sign;
      // a uniform sky gives parts of the irradiance, L cos θ dω/π L
      direction.weight = light.weight * pi / direction.cosine;
      direction.projection = projectionOf(direction.towards);
      direction.pieces = piecesOf(direction.towards);
      directions_.push_back(std::move(direction));
    }
    towards.push_back(directions_[directions_.size() - 2].towards);
    weights.push_back(directions_.back().weight);
  }
  for (Normal& normal : normals_) {
    for (std::size_t pair = 0; pair < towards.size(); ++pair) {
      normal.emission += weights[pair] * std::abs(core::dot(towards[pair], normal.direction));
    }
  }
  exchange_ = exchangeOf(towards, weights);
}

void ScatteredLight::listLeaves() {
  const auto row = static_cast<std::size_t>(counts_[1]);
  const auto layer = static_cast<std::size_t>(counts_[0]) * row;
  const std::vector<double>& densities = field_.values();
  layerDensities_.resize(static_cast<std::size_t>(counts_[2]));
  for (std::size_t voxel = 0; voxel < densities.size(); ++voxel) {
    if (voxel % row == 0) {
      rowStart_.push_back(leafyVoxels_.size());
    }
    if (densities[voxel] > 0.0) {
      leafyVoxels_.push_back(static_cast<std::uint32_t>(voxel));
      columnB_.push_back(static_cast<std::uint32_t>(voxel % row));
      layerDensities_[voxel / layer].push_back(densities[voxel]);
    }
  }
  rowStart_.push_back(leafyVoxels_.size());
  for (std::vector<double>& each : layerDensities_) {
    std::sort(each.begin(), each.end());
    each.erase(std::unique(each.begin(), each.end()), each.end());
  }
  for (const std::uint32_t voxel : leafyVoxels_) {
    const std::vector<double>& each = layerDensities_[voxel / layer];
    densityOf_.push_back(
        static_cast<std::uint32_t>(std::lower_bound(each.begin(), each.end(), densities[voxel]) - each.begin()));
  }
  stride_ = (leafyVoxels_.size() + kScatterBlock - 1) / kScatterBlock * kScatterBlock;
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

double ScatteredLight::projectionOf(const Vec3& towards) const {
  double projection = 0.0;
  for (const Normal& normal : normals_) {
    projection += normal.part * std::abs(core::dot(towards, normal.direction));
  }
  return projection;
}

ScatteredLight::Exchange ScatteredLight::exchangeOf(std::span<const Vec3> towards,
                                                    std::span<const double> weights) const {
  Exchange exchange;
  exchange.ways = towards.size();
  for (std::size_t pair = 0; pair < directions_.size(); pair += 2) {
    const Direction& out = directions_[pair];
    for (std::size_t way = 0; way < towards.size(); ++way) {
      double even = 0.0;
      double odd = 0.0;
      for (const Normal& normal : normals_) {
        const double both = core::dot(out.towards, normal.direction) * core::dot(towards[way], normal.direction);
        const double part = normal.emission > 0.0 ? normal.part / normal.emission : 0.0;
        even += part * std::abs(both);
        odd += part * both;
      }
      // of a direction, not of a pair; the radiance of leaves is their source over their projection
      const double scale = out.projection > 0.0 ? 0.5 * weights[way] / out.projection : 0.0;
      exchange.even.push_back(scale * (options_.transmittance + options_.reflectance) * even);
      exchange.odd.push_back(scale * (options_.transmittance - options_.reflectance) * odd);
    }
  }
  for (std::size_t way = 0; way < towards.size(); ++way) {
    exchange.met.push_back(weights[way] * projectionOf(towards[way]));
  }
  return exchange;
}

double ScatteredLight::takeBeams(std::span<const Beam> beams, const Vec3& up) {
  const double column = 1.0 / static_cast<double>(ground_.size());
  const std::vector<double> dark(stride_, 0.0);
  std::vector<double> rays;
  double met = 0.0;
  for (std::size_t begin = 0; begin < beams.size(); begin += kBeamsAtATime) {
    const auto some = beams.subspan(begin, std::min(kBeamsAtATime, beams.size() - begin));
    std::vector<Vec3> towards;
    std::vector<double> weights;
    std::vector<double> light(some.size() * stride_, 0.0);
    for (std::size_t k = 0; k < some.size(); ++k) {
      core::pollWork();
      const Beam& beam = some[k];
      Direction direction;
      direction.towards = beam.direction * -1.0;
      direction.cosine = core::dot(beam.direction, up);
      direction.projection = beam.projection;
      direction.pieces = piecesOf(direction.towards);
      const double radiance = beam.irradiance / direction.cosine;
      rays.assign(ground_.size(), radiance);
      const Aside aside = follow(direction, dark.data(), rays, radiance, light.data() + k * stride_, kNobody);
      for (std::size_t at = 0; at < rays.size(); ++at) {
        ground_[endOf(direction, at)] += rays[at] * direction.cosine;
      }
      // through the sides as much comes in as the open sky sends there
      fluxes_.incoming += beam.irradiance + radiance * aside.count * direction.cosine * column;
      fluxes_.aside += aside.radiance * direction.cosine * column;
      // the normals take as much as the exact projection says
      const double projection = projectionOf(direction.towards);
      towards.push_back(direction.towards);
      weights.push_back(projection > 0.0 ? beam.projection / projection : 0.0);
    }
    const Exchange exchange = exchangeOf(towards, weights);
    std::vector<double> block(some.size() * kScatterBlock);
    for (std::size_t first = 0; first < stride_; first += kScatterBlock) {
      core::pollWork();
      for (std::size_t k = 0; k < some.size(); ++k) {
        std::copy_n(light.data() + k * stride_ + first, kScatterBlock, block.data() + k * kScatterBlock);
      }
      // nothing comes along the opposite ways; the caller knows exactly what is absorbed
      met += scatterBlock(exchange, block.data(), block.data(), first, false);
    }
  }
  return met;
}

double ScatteredLight::sendOut() {
  const double column = 1.0 / static_cast<double>(ground_.size());
  std::vector<double> rays;
  std::vector<double> source(stride_);
  for (std::size_t number = 0; number < directions_.size(); ++number) {
    core::pollWork();
    const Direction& direction = directions_[number];
    const bool isDown = number % 2 == 0;
    double* light = sources_.data() + number * stride_;
    std::copy_n(light, stride_, source.data());
    rays.assign(ground_.size(), 0.0);
    if (isDown) {
      double* sum = allSources_.data() + number / 2 * stride_;
      for (std::size_t i = 0; i < stride_; ++i) {
        sum[i] += source[i];
      }
    } else {
      std::transform(groundSource_.begin(), groundSource_.end(), rays.begin(), [](double at) { return at / pi; });
    }
    // the light takes the place of the sources
    const Aside aside = follow(direction, source.data(), rays, 0.0, light, kNobody);
    const double flux = direction.cosine * direction.weight;
    fluxes_.aside += aside.radiance * flux * column;
    for (std::size_t at = 0; at < rays.size(); ++at) {
      if (isDown) {
        ground_[endOf(direction, at)] += rays[at] * flux;
      } else {
        fluxes_.up += rays[at] * flux * column;
      }
    }
  }
  const std::size_t pairs = directions_.size() / 2;
  std::vector<double> sums(pairs * kScatterBlock);
  std::vector<double> differences(pairs * kScatterBlock);
  double met = 0.0;
  for (std::size_t first = 0; first < stride_; first += kScatterBlock) {
    core::pollWork();
    for (std::size_t pair = 0; pair < pairs; ++pair) {
      double* down = sources_.data() + 2 * pair * stride_ + first;
      double* up = down + stride_;
      for (std::size_t i = 0; i < kScatterBlock; ++i) {
        sums[pair * kScatterBlock + i] = down[i] + up[i];
        differences[pair * kScatterBlock + i] = down[i] - up[i];
        down[i] = 0.0;
        up[i] = 0.0;
      }
    }
    met += scatterBlock(exchange_, sums.data(), differences.data(), first, true);
  }
  return met;
}

template <typename Passing>
ScatteredLight::Aside ScatteredLight::follow(const Direction& direction, const double* source,
                                             std::vector<double>& rays, double outside, double* mean,
                                             const Passing& passing) const {
  struct Decay {
    double mean = 0.0;  // part of the ray's radiance beyond the source, on average over the voxel
    double lost = 0.0;  // and behind it
  };
  const std::int64_t countA = counts_[0];
  const std::int64_t countB = counts_[1];
  const double whole = voxelSize_ / direction.cosine;  // length of all rays in a voxel
  std::copy_n(source, stride_, mean);
  std::vector<Decay> decays;
  Aside aside;
  const auto leave = [&](std::int64_t a, std::int64_t b) {
    double& ray = rays[static_cast<std::size_t>(a * countB + b)];
    aside.radiance += ray;
    aside.count += 1.0;
    ray = outside;
  };
  Piece before;
  // rays side by side take the same way: piece by piece for all of them
  for (const Piece& piece : direction.pieces) {
    if (!field_.shape().isPeriodic && piece.a != before.a) {
      // the rays that come to the side of the box where they would come in again
      const std::int64_t a = inBox((piece.a > before.a ? 0 : countA - 1) - piece.a, countA);
      for (std::int64_t b = 0; b < countB; ++b) {
        leave(a, b);
      }
    }
    if (!field_.shape().isPeriodic && piece.b != before.b) {
      const std::int64_t b = inBox((piece.b > before.b ? 0 : countB - 1) - piece.b, countB);
      for (std::int64_t a = 0; a < countA; ++a) {
        leave(a, b);
      }
    }
    before = piece;
    const double part = piece.length / whole;
    decays.clear();
    for (const double density : layerDensities_[static_cast<std::size_t>(piece.layer)]) {
      const double depth = direction.projection * density * piece.length;
      const double decay = meanOfDecay(depth);
      decays.push_back({decay * part, decay * depth});
    }
    const std::int64_t shift = inBox(piece.b, countB);
    for (std::int64_t a = 0; a < countA; ++a) {
      const auto row = static_cast<std::size_t>(piece.layer * countA + a);
      double* ray = rays.data() + inBox(a - piece.a, countA) * countB;
      passing(row * static_cast<std::size_t>(countB), ray, shift, part);
      for (std::size_t i = rowStart_[row]; i < rowStart_[row + 1]; ++i) {
        const std::int64_t at = static_cast<std::int64_t>(columnB_[i]) - shift;
        double& own = ray[at < 0 ? at + countB : at];
        const double beyond = own - source[i];
        const Decay& decay = decays[densityOf_[i]];
        mean[i] += beyond * decay.mean;
        own -= beyond * decay.lost;
      }
    }
  }
  return aside;
}

std::size_t ScatteredLight::endOf(const Direction& direction, std::size_t column) const {
  const Piece& last = direction.pieces.back();
  const auto start = static_cast<std::int64_t>(column);
  return static_cast<std::size_t>(inBox(start / counts_[1] + last.a, counts_[0]) * counts_[1] +
                                  inBox(start % counts_[1] + last.b, counts_[1]));
}

double ScatteredLight::scatterBlock(const Exchange& exchange, const double* sums, const double* differences,
                                    std::size_t first, bool isCounted) {
  const std::size_t pairs = directions_.size() / 2;
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    std::array<double, kScatterBlock> even{};
    std::array<double, kScatterBlock> odd{};
    for (std::size_t way = 0; way < exchange.ways; ++way) {
      const double evenPart = exchange.even[pair * exchange.ways + way];
      const double oddPart = exchange.odd[pair * exchange.ways + way];
      for (std::size_t i = 0; i < kScatterBlock; ++i) {
        even[i] += evenPart * sums[way * kScatterBlock + i];
        odd[i] += oddPart * differences[way * kScatterBlock + i];
      }
    }
    double* down = sources_.data() + 2 * pair * stride_ + first;
    for (std::size_t i = 0; i < kScatterBlock; ++i) {
      down[i] += even[i] + odd[i];
      down[stride_ + i] += even[i] - odd[i];
    }
  }
  const double absorptance = 1.0 - options_.reflectance - options_.transmittance;
  double all = 0.0;
  for (std::size_t i = 0; i < kScatterBlock && first + i < leafyVoxels_.size(); ++i) {
    double met = 0.0;
    for (std::size_t way = 0; way < exchange.ways; ++way) {
      met += exchange.met[way] * sums[way * kScatterBlock + i];
    }
    absorbed_[first + i] += isCounted ? met * absorptance : 0.0;
    all += met * field_.values()[leafyVoxels_[first + i]] * voxelSize_;
  }
  return all / static_cast<double>(ground_.size());
}

double ScatteredLight::scatter(double met) {
  const double columns = static_cast<double>(ground_.size());
  const double absorptance = 1.0 - options_.reflectance - options_.transmittance;
  fluxes_.byPlants += met * absorptance;
  double rest = met * (1.0 - absorptance);
  for (std::size_t column = 0; column < ground_.size(); ++column) {
    fluxes_.down += ground_[column] / columns;
    fluxes_.byGround += ground_[column] * (1.0 - options_.groundReflectance) / columns;
    groundSource_[column] = ground_[column] * options_.groundReflectance;
    rest += groundSource_[column] / columns;
    ground_[column] = 0.0;
  }
  return rest;
}

void ScatteredLight::fillDown() {
  const std::int64_t countB = counts_[1];
  down_.assign(field_.values().size(), 0.0);
  std::vector<double> inLeaves(stride_, 0.0);
  std::vector<double> mean(stride_);
  std::vector<double> rays;
  for (std::size_t number = 0; number < directions_.size(); number += 2) {
    core::pollWork();
    const Direction& direction = directions_[number];
    const double flux = direction.cosine * direction.weight;
    rays.assign(ground_.size(), 0.0);
    follow(direction, allSources_.data() + number / 2 * stride_, rays, 0.0, mean.data(),
           [&](std::size_t voxel, const double* ray, std::int64_t shift, double part) {
             // no ray that passes a row without leaves changes
             double* down = down_.data() + voxel;
             for (std::int64_t b = 0; b < countB - shift; ++b) {
               down[shift + b] += ray[b] * (part * flux);
             }
             for (std::int64_t b = countB - shift; b < countB; ++b) {
               down[shift + b - countB] += ray[b] * (part * flux);
             }
           });
    for (std::size_t i = 0; i < stride_; ++i) {
      inLeaves[i] += mean[i] * flux;
    }
  }
  for (std::size_t i = 0; i < leafyVoxels_.size(); ++i) {
    down_[leafyVoxels_[i]] = inLeaves[i];
  }
}

}  // namespace espalier::environment

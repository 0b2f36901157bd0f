#include "environment/light/voxels/voxel_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace espalier::environment {

namespace {

using core::Vec3;

// in voxels. A place farther away has too few digits to walk on from; nobody lays out a stand as long as the longest
// way
constexpr double kFar = 1e6;
constexpr double kLongestWay = 1e5;

std::int64_t wrapped(std::int64_t value, std::int64_t count) {
  const std::int64_t rest = value % count;
  return rest < 0 ? rest + count : rest;
}

/// The spans [begin, end) of a range of voxels of one axis, each of which counts `times`.
struct Spans {
  struct Span {
    std::int64_t begin, end;
    double times;
  };
  std::array<Span, 3> spans{};
  std::size_t count = 0;

  void add(std::int64_t begin, std::int64_t end, double times) {
    if (begin < end) {
      spans[count++] = {begin, end, times};
    }
  }
};

Spans spansOf(std::int64_t middle, std::int64_t reach, std::int64_t count, bool isPeriodic) {
  Spans spans;
  if (!isPeriodic) {
    spans.add(std::max(middle - reach, std::int64_t{0}), std::min(middle + reach + 1, count), 1.0);
    return spans;
  }
  const std::int64_t length = 2 * reach + 1;
  spans.add(0, length >= count ? count : 0, static_cast<double>(length / count));
  const std::int64_t begin = wrapped(middle - reach, count);
  const std::int64_t end = begin + length % count;
  spans.add(begin, std::min(end, count), 1.0);
  spans.add(0, end - count, 1.0);
  return spans;
}

}  // namespace

VoxelField::VoxelField(const Shape& shape, const GridAxes& axes) : shape_(shape), sign_(axes.sign) {
  axis_[2] = axes.up;
  axis_[0] = axes.up == 0 ? 1 : 0;
  axis_[1] = axes.up == 2 ? 1 : 2;
  const auto cellsAlong = [&](std::size_t k) { return shape_.cells[static_cast<std::size_t>(axis_[k])]; };
  countA_ = cellsAlong(0);
  countB_ = cellsAlong(1);
  layers_ = cellsAlong(2);
  values_.assign(static_cast<std::size_t>(countA_ * countB_ * layers_), 0.0);
}

std::array<double, 3> VoxelField::toOwn(const Vec3& direction) const {
  const auto way = componentsOf(direction);
  const auto along = [&](std::size_t k) { return way[static_cast<std::size_t>(axis_[k])]; };
  return {along(0), along(1), along(2) * sign_};
}

Bounds VoxelField::box() const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto low = componentsOf(shape_.position);
  std::array<double, 3> lows{};
  std::array<double, 3> highs{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<std::size_t>(axis_[k]);
    const bool isEndless = shape_.isPeriodic && k < 2;
    lows[axis] = isEndless ? -kInfinity : low[axis];
    highs[axis] = isEndless ? kInfinity : low[axis] + static_cast<double>(shape_.cells[axis]) * shape_.voxelSize;
  }
  return {{lows[0], lows[1], lows[2]}, {highs[0], highs[1], highs[2]}};
}

VoxelField::Voxel VoxelField::voxelOf(const Vec3& point) const {
  const auto p = componentsOf(point);
  const auto low = componentsOf(shape_.position);
  const auto cell = [&](std::size_t k) {
    const auto axis = static_cast<std::size_t>(axis_[k]);
    const double place = std::floor((p[axis] - low[axis]) / shape_.voxelSize);
    return static_cast<std::int64_t>(std::clamp(place, -1e15, 1e15));
  };
  Voxel voxel{cell(0), cell(1), cell(2)};
  if (shape_.isPeriodic) {
    voxel.a = wrapped(voxel.a, countA_);
    voxel.b = wrapped(voxel.b, countB_);
  }
  if (sign_ < 0.0) {
    voxel.layer = layers_ - 1 - voxel.layer;
  }
  return voxel;
}

std::optional<std::size_t> VoxelField::indexOf(const Voxel& voxel) const {
  if (voxel.a < 0 || voxel.a >= countA_ || voxel.b < 0 || voxel.b >= countB_ || voxel.layer < 0 ||
      voxel.layer >= layers_) {
    return std::nullopt;
  }
  return static_cast<std::size_t>((voxel.layer * countA_ + voxel.a) * countB_ + voxel.b);
}

std::optional<std::size_t> VoxelField::indexBeside(const Voxel& voxel, std::int64_t a, std::int64_t b,
                                                   std::int64_t layers) const {
  Voxel beside{voxel.a + a, voxel.b + b, voxel.layer + layers};
  if (shape_.isPeriodic) {
    beside.a = wrapped(beside.a, countA_);
    beside.b = wrapped(beside.b, countB_);
  }
  return indexOf(beside);
}

bool VoxelField::isBeyond(const Voxel& voxel, std::int64_t reach) const {
  const auto isOutside = [&](std::int64_t place, std::int64_t count) {
    return place + reach < 0 || place - reach >= count;
  };
  return voxel.layer + reach < 0 ||
         (!shape_.isPeriodic && (isOutside(voxel.a, countA_) || isOutside(voxel.b, countB_)));
}

Vec3 VoxelField::middleOf(std::size_t index) const {
  const auto number = static_cast<std::int64_t>(index);
  const std::int64_t layer = number / (countA_ * countB_);
  const std::array<std::int64_t, 3> cell{number / countB_ % countA_, number % countB_,
                                         sign_ < 0.0 ? layers_ - 1 - layer : layer};
  std::array<double, 3> place = componentsOf(shape_.position);
  for (std::size_t k = 0; k < 3; ++k) {
    place[static_cast<std::size_t>(axis_[k])] += (static_cast<double>(cell[k]) + 0.5) * shape_.voxelSize;
  }
  return {place[0], place[1], place[2]};
}

VoxelField::Way VoxelField::wayOf(const Vec3& from, const Vec3& direction) const {
  const auto origin = componentsOf(from);
  const auto low = componentsOf(shape_.position);
  const auto way = componentsOf(direction);
  const std::array<std::int64_t, 3> counts{countA_, countB_, layers_};
  Way found;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<std::size_t>(axis_[k]);
    found.start[k] = (origin[axis] - low[axis]) / shape_.voxelSize;
    found.step[k] = way[axis];
  }
  if (sign_ < 0.0) {
    found.start[2] = static_cast<double>(layers_) - found.start[2];
    found.step[2] = -found.step[2];
  }
  // the part of the ray in the box, or between its planes when it repeats itself
  found.end = std::numeric_limits<double>::infinity();
  for (std::size_t k = shape_.isPeriodic ? 2 : 0; k < 3; ++k) {
    const auto count = static_cast<double>(counts[k]);
    if (found.step[k] == 0.0) {
      found.end = found.start[k] < 0.0 || found.start[k] >= count ? 0.0 : found.end;
      continue;
    }
    const double a = -found.start[k] / found.step[k];
    const double b = (count - found.start[k]) / found.step[k];
    found.begin = std::max(found.begin, std::min(a, b));
    found.end = std::min(found.end, std::max(a, b));
  }
  if (shape_.isPeriodic && found.begin < found.end) {
    shorten(found);
  }
  return found;
}

void VoxelField::shorten(Way& way) const {
  const std::array<std::int64_t, 3> counts{countA_, countB_, layers_};
  if (way.begin > kFar) {
    for (std::size_t k = 0; k < 3; ++k) {
      way.start[k] += way.step[k] * way.begin;
    }
    way.end -= way.begin;
    way.begin = 0.0;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    if (!(std::abs(way.start[k]) < kFar)) {
      const double rest = std::fmod(way.start[k], static_cast<double>(counts[k]));
      way.start[k] = std::isfinite(rest) ? rest : 0.0;
    }
  }
  if (way.end - way.begin > kLongestWay) {
    way.share = (way.end - way.begin) / kLongestWay;
    way.end = way.begin + kLongestWay;
  }
}

double VoxelField::integralAlong(const Vec3& from, const Vec3& direction) const {
  const std::array<std::int64_t, 3> counts{countA_, countB_, layers_};
  const auto [start, step, begin, end, share] = wayOf(from, direction);
  double t = begin;
  if (!(t < end)) {
    return 0.0;
  }
  // from voxel to voxel (Amanatides & Woo 1987)
  std::array<std::int64_t, 3> cell{};
  std::array<double, 3> next{};
  std::array<double, 3> width{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double place = start[k] + step[k] * t;
    auto index = static_cast<std::int64_t>(std::floor(place));
    if (k == 2 || !shape_.isPeriodic) {
      index = std::clamp(index, std::int64_t{0}, counts[k] - 1);
    }
    const auto border = static_cast<double>(step[k] > 0.0 ? index + 1 : index);
    next[k] = step[k] == 0.0 ? std::numeric_limits<double>::infinity() : (border - start[k]) / step[k];
    width[k] = step[k] == 0.0 ? 0.0 : 1.0 / std::abs(step[k]);
    cell[k] = k < 2 && shape_.isPeriodic ? wrapped(index, counts[k]) : index;
  }
  double integral = 0.0;
  while (t < end) {
    const std::size_t k = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
    const double until = std::min(next[k], end);
    const auto index = static_cast<std::size_t>((cell[2] * countA_ + cell[0]) * countB_ + cell[1]);
    integral += values_[index] * std::max(until - t, 0.0);
    t = std::max(t, until);
    next[k] += width[k];
    cell[k] += step[k] > 0.0 ? 1 : -1;
    if (cell[k] < 0 || cell[k] >= counts[k]) {
      if (k == 2 || !shape_.isPeriodic) {
        break;
      }
      cell[k] = wrapped(cell[k], counts[k]);
    }
  }
  return integral > 0.0 ? integral * share * shape_.voxelSize : 0.0;
}

void VoxelField::sumLayers() {
  const auto rowSize = static_cast<std::size_t>(countB_ + 1);
  const auto layerSize = static_cast<std::size_t>(countA_ + 1) * rowSize;
  sums_.resize(static_cast<std::size_t>(layers_) * layerSize);
  const double* value = values_.data();
  for (std::int64_t layer = 0; layer < layers_; ++layer) {
    double* above = sums_.data() + static_cast<std::size_t>(layer) * layerSize;
    std::fill(above, above + rowSize, 0.0);
    for (std::int64_t a = 0; a < countA_; ++a) {
      double* row = above + rowSize;
      double inRow = 0.0;
      row[0] = 0.0;
      for (std::int64_t b = 0; b < countB_; ++b) {
        inRow += *value++;
        row[b + 1] = above[b + 1] + inRow;
      }
      above = row;
    }
  }
}

double VoxelField::boxSum(const Voxel& voxel, std::int64_t reach) const {
  if (voxel.layer < 0 || voxel.layer >= layers_) {
    return 0.0;
  }
  const Spans inA = spansOf(voxel.a, reach, countA_, shape_.isPeriodic);
  const Spans inB = spansOf(voxel.b, reach, countB_, shape_.isPeriodic);
  double sum = 0.0;
  for (std::size_t i = 0; i < inA.count; ++i) {
    const auto& a = inA.spans[i];
    for (std::size_t k = 0; k < inB.count; ++k) {
      const auto& b = inB.spans[k];
      sum += a.times * b.times *
             (sumBelow(voxel.layer, a.end, b.end) - sumBelow(voxel.layer, a.begin, b.end) -
              sumBelow(voxel.layer, a.end, b.begin) + sumBelow(voxel.layer, a.begin, b.begin));
    }
  }
  return sum;
}

}  // namespace espalier::environment

#include "environment/soil/soil_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/core/work_meter.h"

namespace espalier::environment {

namespace {

constexpr std::size_t kCacheBytes = std::size_t{5} << 19;  // that the layers of several steps may fill

/// Cells of a run: the old concentrations from `from`, the new ones to `to`.
struct RunOfCells {
  const double* __restrict from;
  double* __restrict to;
  std::size_t count;
  std::size_t row;    // to the neighbour above
  std::size_t slice;  // to the one before; 0: a plane
};

[[gnu::always_inline]] inline void relaxCells(const RunOfCells& run, double own, double others, double staying) {
  const double* __restrict c = run.from;
  double* __restrict n = run.to;
  const double* __restrict below = c - run.row;
  const double* __restrict above = c + run.row;
  if (run.slice == 0) {
    for (std::size_t x = 0; x < run.count; ++x) {
      const double sum = *(c + x - 1) + c[x + 1] + below[x] + above[x];
      n[x] = (own * c[x] + others * sum) * staying;
    }
    return;
  }
  const double* __restrict behind = c - run.slice;
  const double* __restrict before = c + run.slice;
  for (std::size_t x = 0; x < run.count; ++x) {
    const double sum = *(c + x - 1) + c[x + 1] + below[x] + above[x] + behind[x] + before[x];
    n[x] = (own * c[x] + others * sum) * staying;
  }
}

// the same operations by four numbers and by two: the same bits
[[gnu::target("avx2")]] void relaxByFour(const RunOfCells& run, double own, double others, double staying) {
  relaxCells(run, own, others, staying);
}
void relaxByTwo(const RunOfCells& run, double own, double others, double staying) {
  relaxCells(run, own, others, staying);
}

}  // namespace

SoilField::SoilField(const Shape& shape, std::vector<double> initial, std::vector<std::uint8_t> isObstacle,
                     std::vector<std::uint8_t> isSource)
    : shape_(shape),
      initial_(std::move(initial)),
      cells_(initial_),
      isObstacle_(std::move(isObstacle)),
      isSource_(std::move(isSource)) {}

core::Vec3 SoilField::cellSize() const {
  return {shape_.size.x / static_cast<double>(shape_.cells[0]), shape_.size.y / static_cast<double>(shape_.cells[1]),
          shape_.size.z / static_cast<double>(shape_.cells[2])};
}

std::optional<std::size_t> SoilField::cellOf(const core::Vec3& point) const {
  const auto offset = componentsOf(point - shape_.position);
  const auto size = componentsOf(shape_.size);
  std::array<std::size_t, 3> cell{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // a field of one layer reaches as far as one likes across it
    if (axis == 2 && !isInSpace()) {
      continue;
    }
    const auto count = static_cast<double>(shape_.cells[axis]);
    const double place = std::floor(offset[axis] * count / size[axis]);
    if (!(place >= 0.0 && place < count)) {
      return std::nullopt;
    }
    cell[axis] = static_cast<std::size_t>(place);
  }
  return index(cell[0], cell[1], cell[2]);
}

core::Vec3 SoilField::differencesAt(std::size_t cell) const {
  std::array<double, 3> differences{};
  std::size_t stride = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t count = shape_.cells[axis];
    const std::size_t place = cell / stride % count;
    const bool hasLower = place > 0 && isFree(cell - stride);
    const bool hasUpper = place + 1 < count && isFree(cell + stride);
    const double lower = hasLower ? cells_[cell - stride] : cells_[cell];
    const double upper = hasUpper ? cells_[cell + stride] : cells_[cell];
    differences[axis] = (upper - lower) / 2.0;
    stride *= count;
  }
  return {differences[0], differences[1], differences[2]};
}

bool SoilField::isBlocked(const core::Vec3& from, const core::Vec3& to) const {
  if (isObstacle_.empty()) {
    return false;
  }
  // parameters at which the line crosses into the next cell along each axis
  const auto size = componentsOf(cellSize());
  const auto start = componentsOf(from - shape_.position);
  const auto way = componentsOf(to - from);
  std::array<double, 3> place{};
  std::array<double, 3> next{};
  std::array<double, 3> step{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    place[axis] = std::floor(start[axis] / size[axis]);
    step[axis] = way[axis] > 0.0 ? 1.0 : -1.0;
    const double border = (place[axis] + (way[axis] > 0.0 ? 1.0 : 0.0)) * size[axis];
    next[axis] = way[axis] == 0.0 || (axis == 2 && !isInSpace()) ? std::numeric_limits<double>::infinity()
                                                                 : (border - start[axis]) / way[axis];
  }
  const auto isObstacleHere = [&] {
    std::array<std::size_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis == 2 && !isInSpace()) {
        continue;
      }
      if (!(place[axis] >= 0.0 && place[axis] < static_cast<double>(shape_.cells[axis]))) {
        return false;
      }
      cell[axis] = static_cast<std::size_t>(place[axis]);
    }
    return isObstacle_[index(cell[0], cell[1], cell[2])] != 0;
  };
  // no line crosses more cells than this within the box
  const std::size_t most = 4 * (shape_.cells[0] + shape_.cells[1] + shape_.cells[2]) + 16;
  for (std::size_t crossed = 0; crossed < most; ++crossed) {
    if (isObstacleHere()) {
      return true;
    }
    const auto axis = static_cast<std::size_t>(std::min_element(next.begin(), next.end()) - next.begin());
    if (!(next[axis] <= 1.0)) {
      return false;
    }
    place[axis] += step[axis];
    next[axis] += std::abs(size[axis] / way[axis]);
  }
  return false;
}

void SoilField::prepareToSpread(const Diffusion& diffusion) {
  if (diffusion.stepCount > 0 && next_.empty()) {
    sortCells();
    next_.resize(cells_.size());
  }
}

void SoilField::spread(const Diffusion& diffusion) {
  prepareToSpread(diffusion);
  for (std::size_t cell = 0; cell < isSource_.size(); ++cell) {
    if (isSource_[cell] != 0) {
      cells_[cell] = initial_[cell];
    }
  }
  Factors factors;
  const double faces = isInSpace() ? 6.0 : 4.0;
  for (std::size_t count = 0; count <= 6; ++count) {
    const auto n = static_cast<double>(count);
    factors.own[count] = 1.0 - diffusion.relaxation * (diffusion.isOpen ? 1.0 : n / faces);
    factors.others[count] = diffusion.relaxation / faces;
  }
  if (diffusion.tolerance > 0.0) {
    for (int step = 0; step < diffusion.stepCount; ++step) {
      if (isLong(diffusion.stepCount)) {
        core::pollWork();
      }
      relax(1, factors, 1.0);
      if (largestChange() < diffusion.tolerance) {
        break;
      }
    }
  } else if (diffusion.stepCount > 0) {
    // the decay happens while the last step is written
    relax(diffusion.stepCount, factors, diffusion.staying);
    return;
  }
  if (diffusion.staying != 1.0) {
    for (double& concentration : cells_) {
      concentration *= diffusion.staying;
    }
  }
}

std::array<std::ptrdiff_t, 6> SoilField::neighbourOffsets() const {
  const auto row = static_cast<std::ptrdiff_t>(shape_.cells[0]);
  const auto slice = static_cast<std::ptrdiff_t>(shape_.cells[0] * shape_.cells[1]);
  return {-1, 1, -row, row, -slice, slice};
}

void SoilField::sortCells() {
  const auto [nx, ny, nz] = shape_.cells;
  const std::uint8_t all = isInSpace() ? 0b111111 : 0b001111;
  const auto offsets = neighbourOffsets();
  const std::size_t layerSize = isInSpace() ? nx * ny : nx;
  runs_.clear();
  borders_.clear();
  firstRunOf_.clear();
  firstBorderOf_.clear();
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    if (cell % layerSize == 0) {
      firstRunOf_.push_back(runs_.size());
      firstBorderOf_.push_back(borders_.size());
    }
    if (!isFree(cell)) {
      borders_.push_back({cell, 0, false});
      continue;
    }
    const std::size_t x = cell % nx;
    const std::size_t y = cell / nx % ny;
    const std::size_t z = cell / (nx * ny);
    const std::array isThere{x > 0, x + 1 < nx, y > 0, y + 1 < ny, z > 0, z + 1 < nz};
    unsigned neighbours = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      const bool isFreeThere =
          isThere[k] && isFree(static_cast<std::size_t>(static_cast<std::ptrdiff_t>(cell) + offsets[k]));
      neighbours |= isFreeThere ? 1U << k : 0U;
    }
    if (neighbours != all) {
      borders_.push_back({cell, static_cast<std::uint8_t>(neighbours), true});
    } else if (!runs_.empty() && runs_.back().end == cell) {
      ++runs_.back().end;
    } else {
      runs_.push_back({cell, cell + 1});
    }
  }
  firstRunOf_.push_back(runs_.size());
  firstBorderOf_.push_back(borders_.size());
}

void SoilField::relaxLayer(std::size_t layer, const Factors& factors, double staying) {
  const auto offsets = neighbourOffsets();
  for (std::size_t k = firstBorderOf_[layer]; k < firstBorderOf_[layer + 1]; ++k) {
    const auto& [cell, neighbours, isFreeCell] = borders_[k];
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t side = 0; side < 6; ++side) {
      if ((neighbours >> side & 1U) != 0) {
        sum += cells_[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(cell) + offsets[side])];
        ++count;
      }
    }
    const double spread = factors.own[count] * cells_[cell] + factors.others[count] * sum;
    next_[cell] = (isFreeCell ? spread : cells_[cell]) * staying;
  }
  const std::size_t row = shape_.cells[0];
  const std::size_t slice = isInSpace() ? row * shape_.cells[1] : 0;
  const std::size_t count = isInSpace() ? 6 : 4;
  const auto relaxRun = __builtin_cpu_supports("avx2") != 0 ? relaxByFour : relaxByTwo;
  for (std::size_t k = firstRunOf_[layer]; k < firstRunOf_[layer + 1]; ++k) {
    const auto [begin, end] = runs_[k];
    relaxRun({cells_.data() + begin, next_.data() + begin, end - begin, row, slice}, factors.own[count],
             factors.others[count], staying);
  }
}

void SoilField::relax(int stepCount, const Factors& factors, double staying) {
  // several steps go through the layers together, each one layer behind the one before it: what one step has written is
  // still in the cache when the next reads it, and the layer that it overwrites has been read by then
  const auto layers = static_cast<std::ptrdiff_t>(layerCount());
  const std::size_t layerBytes = cells_.size() / layerCount() * sizeof(double);
  const auto together = static_cast<int>(std::clamp<std::size_t>(kCacheBytes / (2 * layerBytes), 4, 12)) - 3;
  for (int done = 0; done < stepCount;) {
    if (isLong(stepCount)) {
      core::pollWork();
    }
    const int count = std::min(together, stepCount - done);
    for (std::ptrdiff_t front = 0; front < layers + count - 1; ++front) {
      for (int step = 0; step < count; ++step) {
        if (front >= step && front - step < layers) {
          const bool isLast = done + step + 1 == stepCount;
          relaxLayer(static_cast<std::size_t>(front - step), factors, isLast ? staying : 1.0);
        }
        cells_.swap(next_);
      }
      if (count % 2 == 1) {
        cells_.swap(next_);
      }
    }
    if (count % 2 == 1) {
      cells_.swap(next_);
    }
    done += count;
  }
}

double SoilField::largestChange() const {
  double change = 0.0;
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    change = std::max(change, std::abs(cells_[cell] - next_[cell]));
  }
  return change;
}

turtle::Field SoilField::field(std::string name, std::string unit) const {
  return {std::move(name), std::move(unit), shape_.cells, shape_.position, cellSize(), cells_};
}

}  // namespace espalier::environment

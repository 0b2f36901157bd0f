#include "environment/soil_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace espalier::environment {

namespace {

std::array<double, 3> componentsOf(const core::Vec3& v) {
  return {v.x, v.y, v.z};
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

void SoilField::spread(const Diffusion& diffusion) {
  for (std::size_t cell = 0; cell < isSource_.size(); ++cell) {
    if (isSource_[cell] != 0) {
      cells_[cell] = initial_[cell];
    }
  }
  // factors of the own concentration and of the sum of the neighbours', by number of free neighbours
  std::array<double, 7> own{};
  std::array<double, 7> others{};
  const double faces = isInSpace() ? 6.0 : 4.0;
  for (std::size_t count = 0; count <= 6; ++count) {
    const auto n = static_cast<double>(count);
    if (diffusion.isAveraging) {
      own[count] = count == 0 ? 1.0 : 1.0 - diffusion.relaxation;
      others[count] = count == 0 ? 0.0 : diffusion.relaxation / n;
    } else {
      own[count] = 1.0 - diffusion.relaxation * (diffusion.isOpen ? 1.0 : n / faces);
      others[count] = diffusion.relaxation / faces;
    }
  }
  for (int step = 0; step < diffusion.stepCount; ++step) {
    if (relax(own, others) < diffusion.tolerance) {
      return;
    }
  }
}

double SoilField::relax(const std::array<double, 7>& own, const std::array<double, 7>& others) {
  next_.resize(cells_.size());
  const auto [nx, ny, nz] = shape_.cells;
  const std::size_t rows = nx;
  const std::size_t slices = nx * ny;
  double change = 0.0;
  const auto relaxCell = [&](std::size_t cell, bool hasLeft, bool hasRight, bool hasBelow, bool hasAbove, bool hasBack,
                             bool hasFront) {
    double sum = 0.0;
    std::size_t count = 0;
    const auto add = [&](bool exists, std::size_t neighbour) {
      if (exists && isFree(neighbour)) {
        sum += cells_[neighbour];
        ++count;
      }
    };
    add(hasLeft, cell - 1);
    add(hasRight, cell + 1);
    add(hasBelow, cell - rows);
    add(hasAbove, cell + rows);
    add(hasBack, cell - slices);
    add(hasFront, cell + slices);
    next_[cell] = isFree(cell) ? own[count] * cells_[cell] + others[count] * sum : cells_[cell];
    change = std::max(change, std::abs(next_[cell] - cells_[cell]));
  };
  for (std::size_t z = 0; z < nz; ++z) {
    for (std::size_t y = 0; y < ny; ++y) {
      const std::size_t begin = index(0, y, z);
      const bool isInner = y > 0 && y + 1 < ny && (nz == 1 || (z > 0 && z + 1 < nz)) && isObstacle_.empty() && nx > 2;
      const auto border = [&](std::size_t x) {
        relaxCell(begin + x, x > 0, x + 1 < nx, y > 0, y + 1 < ny, z > 0, z + 1 < nz);
      };
      if (!isInner) {
        for (std::size_t x = 0; x < nx; ++x) {
          border(x);
        }
        continue;
      }
      // all neighbours are there: the loop that the time goes into, the same additions in the same order
      border(0);
      const std::size_t count = nz == 1 ? 4 : 6;
      const double a = own[count];
      const double b = others[count];
      const double* c = cells_.data() + begin;
      double* n = next_.data() + begin;
      for (std::size_t x = 1; x + 1 < nx; ++x) {
        double sum = c[x - 1] + c[x + 1] + *(c + x - rows) + c[x + rows];
        if (nz > 1) {
          sum = sum + *(c + x - slices) + c[x + slices];
        }
        n[x] = a * c[x] + b * sum;
        change = std::max(change, std::abs(n[x] - c[x]));
      }
      border(nx - 1);
    }
  }
  cells_.swap(next_);
  return change;
}

turtle::Field SoilField::field(std::string name, std::string unit) const {
  return {std::move(name), std::move(unit), shape_.cells, shape_.position, cellSize(), cells_};
}

}  // namespace espalier::environment

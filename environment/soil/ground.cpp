#include "environment/soil/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace espalier::environment {

using core::Vec3;

Ground::Ground(const Shape& shape, const GridAxes& axes)
    : low_{shape.position.x, shape.position.y, shape.position.z}, sign_(axes.sign) {
  axis_ = {axes.up == 0 ? 1 : 0, axes.up == 2 ? 1 : 2, axes.up};
  const std::array<double, 3> sizes{shape.cellSize.x, shape.cellSize.y, shape.cellSize.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    counts_[axis] = shape.cells[static_cast<std::size_t>(axis_[axis])];
    sizes_[axis] = sizes[static_cast<std::size_t>(axis_[axis])];
  }
}

RichardsSolver::Shape Ground::solverShape() const {
  return {{counts_[0], counts_[1]}, counts_[2], sizes_};
}

std::optional<std::size_t> Ground::cellOf(const Vec3& point) const {
  const std::array<double, 3> place{point.x, point.y, point.z};
  std::array<std::size_t, 3> cell{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto world = static_cast<std::size_t>(axis_[axis]);
    const double number = std::floor((place[world] - low_[world]) / sizes_[axis]);
    if (!(number >= 0.0 && number < static_cast<double>(counts_[axis]))) {
      return std::nullopt;
    }
    cell[axis] = static_cast<std::size_t>(number);
  }
  const std::size_t layer = sign_ < 0.0 ? counts_[2] - 1 - cell[2] : cell[2];
  return (layer * counts_[0] + cell[0]) * counts_[1] + cell[1];
}

Vec3 Ground::middleOf(std::size_t cell) const {
  const std::size_t layer = cell / (counts_[0] * counts_[1]);
  const std::array<std::size_t, 3> number{cell / counts_[1] % counts_[0], cell % counts_[1],
                                          sign_ < 0.0 ? counts_[2] - 1 - layer : layer};
  std::array<double, 3> place{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto world = static_cast<std::size_t>(axis_[axis]);
    place[world] = low_[world] + (static_cast<double>(number[axis]) + 0.5) * sizes_[axis];
  }
  return {place[0], place[1], place[2]};
}

std::size_t Ground::fieldIndexOf(std::size_t cell) const {
  const std::size_t layer = cell / (counts_[0] * counts_[1]);
  const std::array<std::size_t, 3> number{cell / counts_[1] % counts_[0], cell % counts_[1],
                                          sign_ < 0.0 ? counts_[2] - 1 - layer : layer};
  std::array<std::size_t, 3> place{};
  std::array<std::size_t, 3> counts{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    place[static_cast<std::size_t>(axis_[axis])] = number[axis];
    counts[static_cast<std::size_t>(axis_[axis])] = counts_[axis];
  }
  return (place[2] * counts[1] + place[1]) * counts[0] + place[0];
}

double Ground::depthOf(std::size_t cell) const {
  const std::size_t layer = cell / (counts_[0] * counts_[1]);
  return (static_cast<double>(counts_[2] - layer) - 0.5) * sizes_[2];
}

double RateSeries::phaseOf(double day) const {
  return period_ > 0.0 ? day - period_ * std::floor(day / period_) : day;
}

double RateSeries::at(double day) const {
  const double phase = phaseOf(day);
  const auto later =
      std::upper_bound(rows_.begin(), rows_.end(), phase, [](double time, const auto& row) { return time < row[0]; });
  if (later != rows_.begin()) {
    return (*(later - 1))[1];
  }
  return period_ > 0.0 && !rows_.empty() ? rows_.back()[1] : 0.0;
}

double RateSeries::remaining(double day) const {
  const double phase = phaseOf(day);
  const auto later =
      std::upper_bound(rows_.begin(), rows_.end(), phase, [](double time, const auto& row) { return time < row[0]; });
  if (later != rows_.end()) {
    return (*later)[0] - phase;
  }
  return period_ > 0.0 && !rows_.empty() ? period_ - phase : std::numeric_limits<double>::infinity();
}

}  // namespace espalier::environment

#include "environment/soil/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/elementary.h"

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
  // a geometric series from the top whose sum is the height of the box
  const double whole = sizes_[2] * static_cast<double>(counts_[2]);
  double sum = 0.0;
  heights_.assign(counts_[2], sizes_[2]);
  if (shape.growth != 1.0) {
    for (std::size_t layer = 0; layer < counts_[2]; ++layer) {
      heights_[layer] = core::pow(shape.growth, static_cast<double>(counts_[2] - 1 - layer));
      sum += heights_[layer];
    }
    for (double& height : heights_) {
      height *= whole / sum;
    }
  }
  edges_.assign(1, 0.0);
  for (std::size_t layer = 0; layer < counts_[2]; ++layer) {
    edges_.push_back(shape.growth == 1.0 ? sizes_[2] * static_cast<double>(layer + 1)
                                         : edges_.back() + heights_[layer]);
  }
}

RichardsSolver::Shape Ground::solverShape() const {
  return {{counts_[0], counts_[1]}, counts_[2], {sizes_[0], sizes_[1]}, heights_};
}

Bounds Ground::box() const {
  std::array<double, 3> high = low_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    high[static_cast<std::size_t>(axis_[axis])] += static_cast<double>(counts_[axis]) * sizes_[axis];
  }
  return {{low_[0], low_[1], low_[2]}, {high[0], high[1], high[2]}};
}

std::optional<std::size_t> Ground::cellOf(const Vec3& point) const {
  const std::array<double, 3> place{point.x, point.y, point.z};
  std::array<std::size_t, 3> cell{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto world = static_cast<std::size_t>(axis_[axis]);
    const auto count = static_cast<double>(counts_[axis]);
    const double way = (place[world] - low_[world]) / sizes_[axis];
    // the upper border belongs to the last cell, also where its coordinate is rounded
    if (!(way >= 0.0 && (way <= count || place[world] <= low_[world] + count * sizes_[axis]))) {
      return std::nullopt;
    }
    cell[axis] = static_cast<std::size_t>(std::min(std::floor(way), count - 1.0));
  }
  std::size_t layer = sign_ < 0.0 ? counts_[2] - 1 - cell[2] : cell[2];
  if (edges_[1] != sizes_[2]) {
    const double along = place[static_cast<std::size_t>(axis_[2])] - low_[static_cast<std::size_t>(axis_[2])];
    const double height = sign_ < 0.0 ? edges_.back() - along : along;
    const auto above = std::upper_bound(edges_.begin() + 1, edges_.end() - 1, height);
    layer = static_cast<std::size_t>(above - edges_.begin()) - 1;
  }
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
  if (edges_[1] != sizes_[2]) {
    const double height = 0.5 * (edges_[layer] + edges_[layer + 1]);
    const auto world = static_cast<std::size_t>(axis_[2]);
    place[world] = low_[world] + (sign_ < 0.0 ? edges_.back() - height : height);
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
  if (edges_[1] != sizes_[2]) {
    return edges_.back() - 0.5 * (edges_[layer] + edges_[layer + 1]);
  }
  return (static_cast<double>(counts_[2] - layer) - 0.5) * sizes_[2];
}

double Ground::spanOf(std::size_t cell, std::size_t axis) const {
  if (axis != 2) {
    return 2.0 * sizes_[axis];
  }
  const std::size_t layer = cell / (counts_[0] * counts_[1]);
  const double own = heights_[layer];
  const double above = layer + 1 < counts_[2] ? heights_[layer + 1] : own;
  const double below = layer > 0 ? heights_[layer - 1] : own;
  return own + 0.5 * (above + below);
}

double Ground::meanAround(std::size_t cell, const std::vector<double>& amounts) const {
  const std::array<std::size_t, 3> place{cell / counts_[1] % counts_[0], cell % counts_[1],
                                         cell / (counts_[0] * counts_[1])};
  double amount = 0.0;
  double height = 0.0;  // of all cells, each as wide as this one
  const auto from = [&](std::size_t axis) { return place[axis] == 0 ? 0 : place[axis] - 1; };
  const auto until = [&](std::size_t axis) { return std::min(place[axis] + 2, counts_[axis]); };
  for (std::size_t layer = from(2); layer < until(2); ++layer) {
    for (std::size_t i = from(0); i < until(0); ++i) {
      for (std::size_t k = from(1); k < until(1); ++k) {
        amount += amounts[(layer * counts_[0] + i) * counts_[1] + k];
        height += heights_[layer];
      }
    }
  }
  return amount * heights_[place[2]] / height;
}

double Ground::sideAcross(std::size_t cell, std::size_t worldAxis) const {
  double area = 1.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double side = axis == 2 ? heights_[cell / (counts_[0] * counts_[1])] : sizes_[axis];
    area *= static_cast<std::size_t>(axis_[axis]) == worldAxis ? 1.0 : side;
  }
  return std::sqrt(area);
}

std::vector<std::size_t> Ground::cellsAcross(std::size_t cell, std::size_t reach, std::size_t worldAxis) const {
  const std::array<std::size_t, 3> place{cell / counts_[1] % counts_[0], cell % counts_[1],
                                         cell / (counts_[0] * counts_[1])};
  std::array<std::size_t, 3> from{}, until{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t way = static_cast<std::size_t>(axis_[axis]) == worldAxis ? 0 : reach;
    from[axis] = place[axis] < way ? 0 : place[axis] - way;
    until[axis] = std::min(place[axis] + way + 1, counts_[axis]);
  }
  std::vector<std::size_t> cells;
  for (std::size_t layer = from[2]; layer < until[2]; ++layer) {
    for (std::size_t i = from[0]; i < until[0]; ++i) {
      for (std::size_t k = from[1]; k < until[1]; ++k) {
        cells.push_back((layer * counts_[0] + i) * counts_[1] + k);
      }
    }
  }
  return cells;
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

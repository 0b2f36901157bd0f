#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "engine/turtle/field.h"
#include "environment/base/configuration.h"
#include "environment/geometry/box_tree.h"
#include "environment/geometry/grid_axes.h"
#include "environment/obstacles/obstacle_scene.h"
#include "environment/soil/richards.h"

namespace espalier::environment {

/// The place of a soil's cells in the world: a box along the world's axes, one of which is up.
class Ground {
 public:
  struct Shape {
    core::Vec3 position;                        // corner with the smallest coordinates
    std::array<std::size_t, 3> cells{1, 1, 1};  // along the world's x, y, z
    core::Vec3 cellSize{1.0, 1.0, 1.0};         // length; along up: the mean
    double growth = 1.0;                        // height of a cell over that of the cell above it
  };
  Ground() = default;
  Ground(const Shape& shape, const GridAxes& axes);

  [[nodiscard]] RichardsSolver::Shape solverShape() const;
  [[nodiscard]] Bounds box() const;
  /// The cell of a point by the solver's numbering; nothing outside. All borders of the box belong to it.
  [[nodiscard]] std::optional<std::size_t> cellOf(const core::Vec3& point) const;
  [[nodiscard]] core::Vec3 middleOf(std::size_t cell) const;
  /// Index of a cell in the values of field().
  [[nodiscard]] std::size_t fieldIndexOf(std::size_t cell) const;
  /// Depth of a cell's middle below the top of the box, length.
  [[nodiscard]] double depthOf(std::size_t cell) const;
  /// How far up a point is, length.
  [[nodiscard]] double heightOf(const core::Vec3& point) const {
    return sign_ * (axis_[2] == 0 ? point.x : axis_[2] == 1 ? point.y : point.z);
  }
  /// The side of a square of the area that a cell has across a world axis, length.
  [[nodiscard]] double sideAcross(std::size_t cell, std::size_t worldAxis) const;
  /// The cells up to `reach` cells away from a cell in both directions across a world axis, and the cell itself.
  [[nodiscard]] std::vector<std::size_t> cellsAcross(std::size_t cell, std::size_t reach, std::size_t worldAxis) const;
  /// The mean of an amount per volume over a cell and those that touch it, times the cell's volume (cells).
  [[nodiscard]] double meanAround(std::size_t cell, const std::vector<double>& amounts) const;
  /// Central differences of a quantity of the cells, per length, in world coordinates. A neighbour that is not open
  /// counts as having the cell's own value.
  template <typename Value>
  [[nodiscard]] core::Vec3 gradientAt(std::size_t cell, const RichardsSolver& water, const Value& value) const {
    std::array<double, 3> gradient{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t next = stride(axis);
      const double own = value(cell);
      const double above = water.hasFace(cell, axis) ? value(cell + next) : own;
      const double below = cell >= next && water.hasFace(cell - next, axis) ? value(cell - next) : own;
      const double sign = axis == 2 ? sign_ : 1.0;
      gradient[static_cast<std::size_t>(axis_[axis])] = sign * (above - below) / spanOf(cell, axis);
    }
    return {gradient[0], gradient[1], gradient[2]};
  }

  /// A quantity of the cells as a field along the world's axes. Cells that grow with depth are sampled in equal ones.
  template <typename Value>
  [[nodiscard]] turtle::Field field(const std::string& name, const std::string& unit, const Value& value) const {
    turtle::Field field{name, unit, {}, {low_[0], low_[1], low_[2]}, {}, {}};
    std::array<double, 3> sizes{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      field.cells[static_cast<std::size_t>(axis_[axis])] = counts_[axis];
      sizes[static_cast<std::size_t>(axis_[axis])] = sizes_[axis];
    }
    field.cellSize = {sizes[0], sizes[1], sizes[2]};
    for (std::size_t z = 0; z < field.cells[2]; ++z) {
      for (std::size_t y = 0; y < field.cells[1]; ++y) {
        for (std::size_t x = 0; x < field.cells[0]; ++x) {
          const auto middle = [](double low, std::size_t number, double size) {
            return low + (static_cast<double>(number) + 0.5) * size;
          };
          field.values.push_back(value(
              *cellOf({middle(low_[0], x, sizes[0]), middle(low_[1], y, sizes[1]), middle(low_[2], z, sizes[2])})));
        }
      }
    }
    return field;
  }

 private:
  [[nodiscard]] std::size_t stride(std::size_t axis) const {
    return axis == 0 ? counts_[1] : axis == 1 ? 1 : counts_[0] * counts_[1];
  }

  /// Distance of the middles of both neighbours of a cell along an axis, where a missing one is as high as the cell.
  [[nodiscard]] double spanOf(std::size_t cell, std::size_t axis) const;

  std::array<double, 3> low_{};          // by world axis
  std::array<int, 3> axis_{0, 2, 1};     // world axes of the solver's two horizontal directions and of up
  std::array<std::size_t, 3> counts_{};  // by solver axis
  std::array<double, 3> sizes_{};        // of a cell by solver axis; along up: the mean
  std::vector<double> heights_;          // of the layers, the lowest first, length
  std::vector<double> edges_;            // heights of the layers' lower borders above the bottom, and of the top
  double sign_ = 1.0;                    // -1: up is against the axis
};

/// A rate that changes at given times and stays until the next: rows of day and rate. With a period above 0 it repeats.
class RateSeries {
 public:
  RateSeries() = default;
  /// `rows` ascend by day.
  RateSeries(ConfigurationRows rows, double period) : rows_(std::move(rows)), period_(period) {}

  [[nodiscard]] bool isEmpty() const { return rows_.empty(); }
  /// The rate at a time, 0 before the first row.
  [[nodiscard]] double at(double day) const;
  /// The days from a time until the rate changes; infinite after the last row.
  [[nodiscard]] double remaining(double day) const;

 private:
  [[nodiscard]] double phaseOf(double day) const;

  ConfigurationRows rows_;
  double period_ = 0.0;
};

}  // namespace espalier::environment

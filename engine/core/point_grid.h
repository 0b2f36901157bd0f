#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/core/index_lists.h"

namespace espalier::core {

/// Points of a plane in the cells of a grid, to find those near a triangle. A point is in it once. The points must
/// outlive it.
class PointGrid {
 public:
  using Point = std::array<double, 2>;
  static constexpr std::uint32_t kNone = IndexLists::kNone;

  /// Without any of the points, of which there is at least one.
  explicit PointGrid(const std::vector<Point>& points)
      : points_(points),
        side_(static_cast<std::uint32_t>(std::clamp(std::sqrt(static_cast<double>(points.size())), 1.0, kMostCells))),
        low_(points[0]),
        cells_(std::size_t{side_} * side_, points.size()) {
    Point high = low_;
    for (const Point& p : points) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        low_[axis] = std::min(low_[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double extent = high[axis] - low_[axis];
      scale_[axis] = extent > 0.0 ? side_ / extent : 0.0;
    }
  }

  void insert(std::uint32_t point) { cells_.insert(cellOf(points_[point]), point); }
  void remove(std::uint32_t point) { cells_.remove(cellOf(points_[point]), point); }

  /// The first point found of which `holds` is true, among those in the cells that a triangle touches; kNone: none.
  template <typename Holds>
  [[nodiscard]] std::uint32_t findNear(const Point& a, const Point& b, const Point& c, const Holds& holds) const {
    const Triangle triangle{inCells(a), inCells(b), inCells(c)};
    const auto [left, right] = std::minmax({triangle[0][0], triangle[1][0], triangle[2][0]});
    const auto [low, high] = std::minmax({triangle[0][1], triangle[1][1], triangle[2][1]});
    const bool isWide = right - left > kFewColumns;
    const std::uint32_t top = placeOf(high);
    for (std::uint32_t row = placeOf(low); row <= top; ++row) {
      // of a large triangle only the columns that it has in this row: a long spike touches few cells of its bounds
      const Range columns = isWide ? extentIn(triangle, row) : Range{left, right};
      const std::uint32_t last = placeOf(columns[1]);
      for (std::uint32_t column = placeOf(columns[0]); column <= last; ++column) {
        for (std::uint32_t k = cells_.first(cellAt(row, column)); k != kNone; k = cells_.next(k)) {
          if (holds(k)) {
            return k;
          }
        }
      }
    }
    return kNone;
  }

 private:
  using Triangle = std::array<Point, 3>;
  using Range = std::array<double, 2>;

  static constexpr double kMostCells = 1024.0;  // of a side
  static constexpr double kFewColumns = 4.0;
  static constexpr double kSlack = 0.01;  // cells around a triangle that count as touched, far more than rounding

  // in units of cells, from the lowest corner of the grid
  [[nodiscard]] Point inCells(const Point& p) const {
    return {(p[0] - low_[0]) * scale_[0], (p[1] - low_[1]) * scale_[1]};
  }
  // never falls where the coordinate grows
  [[nodiscard]] std::uint32_t placeOf(double cells) const {
    return static_cast<std::uint32_t>(std::min(std::max(0.0, cells), side_ - 1.0));
  }
  [[nodiscard]] std::size_t cellAt(std::uint32_t row, std::uint32_t column) const {
    return std::size_t{row} * side_ + column;
  }
  [[nodiscard]] std::size_t cellOf(const Point& p) const {
    const Point cells = inCells(p);
    return cellAt(placeOf(cells[1]), placeOf(cells[0]));
  }

  // from where to where a triangle lies in a row, in units of cells
  [[nodiscard]] static Range extentIn(const Triangle& triangle, std::uint32_t row) {
    const double bottom = row - kSlack;
    const double top = row + 1.0 + kSlack;
    Range extent{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [lower, upper] =
          std::minmax(triangle[i], triangle[(i + 1) % 3], [](const Point& p, const Point& q) { return p[1] < q[1]; });
      if (upper[1] < bottom || lower[1] > top) {
        continue;
      }
      // where the edge enters the row and where it leaves it
      const double slope = upper[1] > lower[1] ? (upper[0] - lower[0]) / (upper[1] - lower[1]) : 0.0;
      const double from = lower[1] < bottom ? lower[0] + (bottom - lower[1]) * slope : lower[0];
      const double to = upper[1] > top ? lower[0] + (top - lower[1]) * slope : upper[0];
      extent = {std::min({extent[0], from, to}), std::max({extent[1], from, to})};
    }
    return {extent[0] - kSlack, extent[1] + kSlack};
  }

  const std::vector<Point>& points_;
  std::uint32_t side_;  // cells
  Point low_;
  Point scale_{};     // cells per unit
  IndexLists cells_;  // of points, by cell
};

}  // namespace espalier::core

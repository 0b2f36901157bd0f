#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

namespace espalier::environment {

/// Linear equations for the cells of a box, each of which is linked to its six neighbours: matrix and solution. Cell
/// (i, k) of a layer has the index (layer * columns[0] + i) * columns[1] + k; the columns go up.
class FlowSystem {
 public:
  FlowSystem(std::array<std::size_t, 2> columns, std::size_t layers);

  /// Sets all entries to 0.
  void clear();
  /// The entry of a cell with itself.
  double& diagonal(std::size_t cell) { return diagonal_[cell]; }
  /// The entry in the row of a cell for its next neighbour along an axis (0, 1: across; 2: up).
  double& next(std::size_t cell, std::size_t axis) { return next_[axis][cell]; }
  /// The entry in the row of that neighbour for the cell.
  double& back(std::size_t cell, std::size_t axis) { return back_[axis][cell]; }

  /// Solves for the right side `right` into `result`: one column by elimination, more by stabilised bi-conjugate
  /// gradients (van der Vorst 1992), preconditioned with the exact solution of each column. False when it does not get
  /// within `tolerance` of the right side (relative, Euclidean) or divides by 0.
  [[nodiscard]] bool solve(const std::vector<double>& right, double tolerance, std::vector<double>& result) {
    return solve(right, tolerance, result, nullptr);
  }
  /// A function that adds to the product of the matrix and a vector.
  using Addition = std::function<void(const std::vector<double>& v, std::vector<double>& result)>;
  /// The same with a matrix to which `addition` adds more; null: nothing.
  [[nodiscard]] bool solve(const std::vector<double>& right, double tolerance, std::vector<double>& result,
                           const Addition& addition);

 private:
  [[nodiscard]] std::size_t stride(std::size_t axis) const {
    return axis == 0 ? columns_[1] : axis == 1 ? 1 : columns_[0] * columns_[1];
  }
  void eliminate();
  void solveColumns(const std::vector<double>& right, std::vector<double>& result) const;
  void multiply(const std::vector<double>& v, const Addition& addition, std::vector<double>& result) const;

  std::array<std::size_t, 2> columns_;
  std::vector<double> diagonal_;
  std::array<std::vector<double>, 3> next_, back_;  // (cells)
  std::vector<double> pivot_, factor_;              // of the elimination of the columns (cells)
  std::vector<double> rest_, shadow_, direction_, turned_, image_, half_, halfImage_;  // of the iteration (cells)
};

}  // namespace espalier::environment

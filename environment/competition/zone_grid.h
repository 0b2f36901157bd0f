#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace espalier::environment {

/// Finds the discs over a point of a plane: a grid whose cells list the discs that reach into them. The number of cells
/// follows the number of discs, and large discs make the cells larger.
class ZoneGrid {
 public:
  struct Disc {
    double x = 0.0;
    double z = 0.0;
    double radius = 0.0;
  };

  /// O(discs).
  explicit ZoneGrid(std::span<const Disc> discs);
  /// Numbers of discs, ascending: at least those that the point lies in.
  [[nodiscard]] std::span<const std::uint32_t> near(double x, double z) const {
    if (discs_.empty()) {
      return {};
    }
    const std::size_t cell = cellOf(x, 0) * counts_[1] + cellOf(z, 1);
    return {discs_.data() + begins_[cell], begins_[cell + 1] - begins_[cell]};
  }

 private:
  /// The cells that a disc reaches into, first and last along both axes.
  struct Reach {
    std::array<std::size_t, 2> first;
    std::array<std::size_t, 2> last;
  };

  [[nodiscard]] std::size_t cellOf(double coordinate, std::size_t axis) const {
    // a comparison with NaN is false: an infinite extent has one cell
    const double cell = (coordinate - low_[axis]) * cellsPerLength_[axis];
    if (!(cell > 0.0)) {
      return 0;
    }
    return cell < static_cast<double>(counts_[axis]) ? static_cast<std::size_t>(cell) : counts_[axis] - 1;
  }
  [[nodiscard]] Reach reachOf(const Disc& disc) const;
  [[nodiscard]] std::uint64_t entriesOf(std::span<const Disc> discs) const;
  void setCounts(std::size_t cellsAlong, const std::array<double, 2>& extent);

  std::array<double, 2> low_{};
  std::array<double, 2> cellsPerLength_{};
  std::array<std::size_t, 2> counts_{1, 1};
  std::vector<std::size_t> begins_;   // first entry of discs_ by cell (cells + 1)
  std::vector<std::uint32_t> discs_;  // numbers, by cell
};

}  // namespace espalier::environment

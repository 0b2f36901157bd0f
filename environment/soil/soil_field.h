#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/field.h"
#include "environment/geometry/box_tree.h"

namespace espalier::environment {

/// How the content of a soil field spreads.
struct Diffusion {
  int stepCount = 0;        // in one step of the simulation
  double tolerance = 0.0;   // stop before when no cell changes by as much; 0: never
  double relaxation = 0.5;  // 0 … 1
  bool isOpen = false;      // matter that leaves the box through its sides is gone
  double staying = 1.0;     // part of the matter that has not decayed at the end
};

/// Concentrations in the cells of a box, with impermeable obstacles and sources of constant concentration.
class SoilField {
 public:
  struct Shape {
    core::Vec3 position;                        // low corner of the box
    core::Vec3 size{1.0, 1.0, 1.0};             // of the box
    std::array<std::size_t, 3> cells{1, 1, 1};  // along x, y, z
  };

  /// `initial`, `isObstacle` and `isSource` are by cell, x fastest, then y upwards, then z; the last two may be empty.
  SoilField(const Shape& shape, std::vector<double> initial, std::vector<std::uint8_t> isObstacle,
            std::vector<std::uint8_t> isSource);

  [[nodiscard]] const Shape& shape() const { return shape_; }
  [[nodiscard]] Bounds box() const { return {shape_.position, shape_.position + shape_.size}; }
  [[nodiscard]] bool isInSpace() const { return shape_.cells[2] > 1; }
  [[nodiscard]] core::Vec3 cellSize() const;

  /// Allocates the memory of spread(), so that spread() itself cannot fail.
  void prepareToSpread(const Diffusion& diffusion);
  /// Goes back to the initial concentrations.
  void reset() { cells_ = initial_; }
  [[nodiscard]] std::vector<double>& cells() { return cells_; }
  [[nodiscard]] const std::vector<double>& cells() const { return cells_; }
  /// The cell of a point; nothing outside the box. Low borders belong to it, high ones do not.
  [[nodiscard]] std::optional<std::size_t> cellOf(const core::Vec3& point) const;
  /// The concentrations as a field of that name and unit.
  [[nodiscard]] turtle::Field field(std::string name, std::string unit) const;
  /// Differences of the concentrations of the neighbours on both sides, halved: per cell, not per length. A neighbour
  /// beyond the border or in an obstacle counts as having the cell's own concentration.
  [[nodiscard]] core::Vec3 differencesAt(std::size_t cell) const;
  /// Whether a straight line meets an obstacle. O(cells crossed).
  [[nodiscard]] bool isBlocked(const core::Vec3& from, const core::Vec3& to) const;

  /// Sources get their concentration back, then everything spreads. Every face of two free cells lets pass
  /// relaxation/(number of faces of a cell) of the difference, so that matter is conserved. A step reads the field of
  /// the step before only. O(cells · steps), at the speed of memory where obstacles are few.
  void spread(const Diffusion& diffusion);

  /// Whether a step with so many sweeps over the cells may be given up while it computes: then its loops call
  /// core::pollWork(), and it stands in orGoBack(). To keep the cells costs about a sweep, so short steps go on.
  [[nodiscard]] static bool isLong(int sweeps) { return sweeps > kShortSweeps; }
  /// Makes a step with so many sweeps. The cells of a long one are as before when it ends with an exception.
  template <typename Step>
  void orGoBack(int sweeps, Step&& step) {
    if (!isLong(sweeps)) {
      step();
      return;
    }
    kept_ = cells_;
    try {
      step();
    } catch (...) {
      cells_ = kept_;
      throw;
    }
  }

 private:
  static constexpr int kShortSweeps = 8;
  [[nodiscard]] std::size_t index(std::size_t x, std::size_t y, std::size_t z) const {
    return (z * shape_.cells[1] + y) * shape_.cells[0] + x;
  }
  [[nodiscard]] bool isFree(std::size_t cell) const { return isObstacle_.empty() || isObstacle_[cell] == 0; }
  /// Factors of the own concentration and of the sum of the neighbours', by number of free neighbours.
  struct Factors {
    std::array<double, 7> own{};
    std::array<double, 7> others{};
  };
  /// A cell that lacks a free neighbour, or is an obstacle.
  struct BorderCell {
    std::size_t cell = 0;
    std::uint8_t neighbours = 0;  // bits of those that are free: left, right, below, above, behind, before
    bool isFree = true;
  };
  /// Neighbouring cells of a row, all of whose neighbours are free: the hot loop.
  struct Run {
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  void sortCells();
  [[nodiscard]] std::array<std::ptrdiff_t, 6> neighbourOffsets() const;
  [[nodiscard]] std::size_t layerCount() const { return isInSpace() ? shape_.cells[2] : shape_.cells[1]; }
  void relaxLayer(std::size_t layer, const Factors& factors, double staying);
  void relax(int stepCount, const Factors& factors, double staying);
  [[nodiscard]] double largestChange() const;

  Shape shape_;
  std::vector<double> initial_;
  std::vector<double> cells_;
  std::vector<double> next_;  // of a relaxation; empty before the first one
  std::vector<double> kept_;  // cells before a long step; empty before the first one
  std::vector<Run> runs_;     // these two hold every cell once; empty before the first relaxation
  std::vector<BorderCell> borders_;
  std::vector<std::size_t> firstRunOf_;  // by layer, a slice or in a plane a row (layerCount() + 1)
  std::vector<std::size_t> firstBorderOf_;
  std::vector<std::uint8_t> isObstacle_;  // by cell; empty: none is
  std::vector<std::uint8_t> isSource_;    // by cell; empty: none is
};

}  // namespace espalier::environment

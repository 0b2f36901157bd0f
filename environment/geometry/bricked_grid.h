#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace espalier::environment {

/// A three-dimensional array of numbers that are 0 until written. Memory is taken in bricks of 8 x 8 x 8 cells where
/// something was written, so an almost empty field of 1000^3 cells is affordable, and clear() costs the bricks in use.
template <typename T>
class BrickedGrid {
 public:
  BrickedGrid() = default;
  /// `size` cells in each direction, at least 1.
  explicit BrickedGrid(std::int64_t size)
      : size_(size),
        bricksPerSide_((size + kSide - 1) / kSide),
        brickOf_(static_cast<std::size_t>(bricksPerSide_ * bricksPerSide_ * bricksPerSide_), 0) {}

  [[nodiscard]] bool contains(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return x >= 0 && x < size_ && y >= 0 && y < size_ && z >= 0 && z < size_;
  }
  /// The value of a cell; 0 outside.
  [[nodiscard]] T get(std::int64_t x, std::int64_t y, std::int64_t z) const {
    if (!contains(x, y, z)) {
      return T{};
    }
    const std::uint32_t brick = brickOf_[brickIndex(x, y, z)];
    return brick == 0 ? T{} : bricks_[brick - 1][cellIndex(x, y, z)];
  }
  /// A cell inside the grid, for writing.
  [[nodiscard]] T& at(std::int64_t x, std::int64_t y, std::int64_t z) {
    std::uint32_t& brick = brickOf_[brickIndex(x, y, z)];
    if (brick == 0) {
      used_.push_back(brickIndex(x, y, z));
      if (used_.size() > bricks_.size()) {
        bricks_.emplace_back();
      }
      brick = static_cast<std::uint32_t>(used_.size());
      bricks_[brick - 1].fill(T{});
    }
    return bricks_[brick - 1][cellIndex(x, y, z)];
  }
  /// The cells from z on with the same x and y that lie one after the other in memory, at most those before `endZ`; for
  /// writing.
  [[nodiscard]] std::span<T> run(std::int64_t x, std::int64_t y, std::int64_t z, std::int64_t endZ) {
    const std::int64_t length = kSide - z % kSide;
    return {&at(x, y, z), static_cast<std::size_t>(length < endZ - z ? length : endZ - z)};
  }
  /// All cells become 0; the bricks are kept for the next use.
  void clear() {
    for (const std::size_t index : used_) {
      brickOf_[index] = 0;
    }
    used_.clear();
  }
  [[nodiscard]] std::size_t usedBrickCount() const { return used_.size(); }

 private:
  static constexpr std::int64_t kSide = 8;

  [[nodiscard]] std::size_t brickIndex(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>(((x / kSide) * bricksPerSide_ + y / kSide) * bricksPerSide_ + z / kSide);
  }
  [[nodiscard]] static std::size_t cellIndex(std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<std::size_t>(((x % kSide) * kSide + y % kSide) * kSide + z % kSide);
  }

  std::int64_t size_ = 0;
  std::int64_t bricksPerSide_ = 0;
  std::vector<std::uint32_t> brickOf_;  // brick number + 1 by place, 0: none (bricksPerSide^3)
  std::vector<std::array<T, static_cast<std::size_t>(kSide* kSide* kSide)>> bricks_;
  std::vector<std::size_t> used_;  // places with a brick, in the order of first use
};

}  // namespace espalier::environment

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace espalier::environment {

struct PlanePoint {
  double x = 0.0;
  double y = 0.0;

  auto operator<=>(const PlanePoint&) const = default;
};

/// Σ 1/(1 + d²) over all points of a plane, at a small square pattern of places around each of many centres, by the
/// fast multipole method with Chebyshev interpolation (Fong & Darve, Journal of Computational Physics 228, 2009). The
/// kernel has no singularity at real distances. So boxes of a quarter of the length unit act through their nodes at any
/// distance, and the cost of a crowd follows from its area, not from its count. Points are sorted first, so the sums do
/// not depend on the order of points and centres. Errors are below 10⁻⁶ of the largest sum.
class TipField {
 public:
  /// O(n log n).
  explicit TipField(std::vector<PlanePoint> points);

  /// Calls `visit(centre, i, j, sum)` once for every place (centre.x + offsets[i], centre.y + offsets[j]). The order of
  /// the places of one centre depends on places only. `offsets` are ascending, at most kMostOffsets. O(n + centres) for
  /// points spread evenly.
  template <typename Visit>
  void sumAround(std::span<const PlanePoint> centres, std::span<const double> offsets, const Visit& visit) {
    std::array<double, kMostOffsets * kMostOffsets> sums{};
    begin(centres, offsets);
    while (const Leaf* leaf = nextLeaf()) {
      for (const Part& part : leaf->parts) {
        sumPart(*leaf, part, sums);
        const double* sum = sums.data();
        for (std::size_t j = part.firstJ; j < part.lastJ; ++j) {
          for (std::size_t i = part.firstI; i < part.lastI; ++i) {
            visit(part.centre, i, j, *sum++);
          }
        }
      }
    }
  }

  static constexpr std::size_t kMostOffsets = 6;

 private:
  static constexpr std::size_t kNodes = 7;  // Chebyshev nodes along a side
  static constexpr std::size_t kNodeCount = kNodes * kNodes;
  using Expansion = std::array<double, kNodeCount>;  // by node, x fastest
  using Matrix = std::array<double, kNodes * kNodes>;

  struct Square {
    double x = 0.0;  // the middle
    double y = 0.0;
    double half = 0.0;  // half a side
  };
  struct Box {
    Square square;
    std::uint32_t begin = 0;  // points_[begin, end)
    std::uint32_t end = 0;
    std::array<std::uint32_t, 4> children{};  // 0: none
    Expansion weights{};                      // of its points, at the nodes
    bool isLeaf = true;
  };
  /// The places of a centre that lie in a square: offsets [firstI, lastI) x [firstJ, lastJ).
  struct Part {
    std::uint32_t centre = 0;
    std::uint8_t firstI = 0, lastI = 0, firstJ = 0, lastJ = 0;
  };
  /// A square in which sums are asked for, before it is divided.
  struct Target {
    Square square;
    int depth = 0;
    std::vector<Part> parts;
    std::vector<std::uint32_t> boxes;  // that do not act through `far` yet
    Expansion far{};                   // sums over far tips, at the nodes
  };
  using Leaf = Target;

  void begin(std::span<const PlanePoint> centres, std::span<const double> offsets);
  const Leaf* nextLeaf();
  void sumPart(const Leaf& leaf, const Part& part, std::array<double, kMostOffsets * kMostOffsets>& sums) const;

  [[nodiscard]] static Square quarterOf(const Square& square, std::size_t quarter);
  void buildBox(std::uint32_t index, int depth);
  void gather(Box& box) const;
  [[nodiscard]] std::array<double, kNodes> basisAt(double u) const;
  [[nodiscard]] bool isLeaf(const Target& target) const;
  void addFarBoxes(Target& target);
  void actOn(Target& target, const Box& box);
  [[nodiscard]] const std::vector<double>& matrixOf(const Target& target, const Square& from);
  void divide(const Target& target);

  std::array<double, kNodes> chebyshev_{};
  std::array<double, kNodes> scale_{};  // of the basis polynomials
  std::array<Matrix, 2> halves_{};      // basis at the nodes of the lower and the upper half: [node of half][basis]
  std::vector<PlanePoint> points_;      // grouped by leaf
  std::vector<Box> boxes_;              // the root first
  Square root_;

  // of one call of sumAround
  std::span<const PlanePoint> centres_;
  std::span<const double> offsets_;
  std::vector<Target> open_;  // still to divide, the next one last
  Leaf leaf_;
  std::vector<std::vector<std::vector<double>>> matrices_;  // by depth and offset of equal squares
  std::vector<double> other_;                               // of two squares that are not equal
};

}  // namespace espalier::environment

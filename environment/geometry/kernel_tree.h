#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace espalier::environment {

/// A point in a plane with a weight.
struct WeightedPoint {
  double x = 0.0;
  double y = 0.0;
  double weight = 0.0;

  auto operator<=>(const WeightedPoint&) const = default;
};

/// Sums a smooth radial kernel over many points in O(log n) a place instead of O(n): a quadtree whose boxes hold their
/// points' weights interpolated to 6 x 6 Chebyshev nodes, used where the box is far enough away (Fong & Darve, Journal
/// of Computational Physics 228, 2009, without their second expansion). Points are sorted first, so sums do not depend
/// on the order in which they were given.
class KernelTree {
 public:
  /// Building is O(n log n). `isExact`: every sum goes over all points.
  KernelTree(std::vector<WeightedPoint> points, bool isExact);

  /// Σ weight · kernel(d²) over all points. `kernel` takes the squared distance.
  template <typename Kernel>
  [[nodiscard]] double sum(double x, double y, const Kernel& kernel) const {
    double total = 0.0;
    if (!nodes_.empty()) {
      addNode(0, x, y, kernel, total);
    }
    return total;
  }

 private:
  static constexpr std::size_t kNodes = 6;  // Chebyshev nodes along a side
  static constexpr std::uint32_t kLeafSize = 32;
  static constexpr int kMaximumDepth = 48;

  struct Node {
    double x = 0.0;  // middle of the square
    double y = 0.0;
    double half = 0.0;  // half its side
    std::uint32_t begin = 0;
    std::uint32_t end = 0;                          // points_[begin, end)
    std::array<std::uint32_t, 4> children{};        // 0: none
    std::array<double, kNodes * kNodes> weights{};  // at the Chebyshev nodes
    bool isLeaf = true;
  };

  void build(std::uint32_t node, int depth);
  void interpolate(Node& node) const;

  template <typename Kernel>
  void addNode(std::uint32_t index, double x, double y, const Kernel& kernel, double& total) const {
    const Node& node = nodes_[index];
    const double dx = x - node.x;
    const double dy = y - node.y;
    // far: at least three half sides beyond the border of the square
    const double reach = 4.0 * node.half;
    if (!isExact_ && (dx > reach || dx < -reach || dy > reach || dy < -reach) &&
        node.end - node.begin > kNodes * kNodes) {
      for (std::size_t j = 0; j < kNodes; ++j) {
        for (std::size_t i = 0; i < kNodes; ++i) {
          const double ex = dx - node.half * chebyshev_[i];
          const double ey = dy - node.half * chebyshev_[j];
          total += node.weights[j * kNodes + i] * kernel(ex * ex + ey * ey);
        }
      }
      return;
    }
    if (node.isLeaf) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        const double ex = x - points_[i].x;
        const double ey = y - points_[i].y;
        total += points_[i].weight * kernel(ex * ex + ey * ey);
      }
      return;
    }
    for (const std::uint32_t child : node.children) {
      if (child != 0) {
        addNode(child, x, y, kernel, total);
      }
    }
  }

  bool isExact_;
  std::array<double, kNodes> chebyshev_{};
  std::vector<WeightedPoint> points_;  // grouped by leaf
  std::vector<Node> nodes_;            // the root first
};

}  // namespace espalier::environment

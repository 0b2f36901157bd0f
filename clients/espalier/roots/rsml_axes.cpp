#include "clients/espalier/roots/rsml_axes.h"

#include <algorithm>
#include <cmath>

#include "engine/core/number_text.h"

namespace espalier::roots {

namespace {

/// Points that are looked at to find where laterals begin, in all. A file of people needs a small part of it.
constexpr std::uint64_t kMostLooks = 1'000'000'000;

class AxisJoin {
 public:
  explicit AxisJoin(std::span<const RsmlAxis> axes) : axes_(axes) {}

  [[nodiscard]] tl::expected<RootSystem, std::string> joined(const std::string& unit) {
    RootSystem roots;
    roots.unit = unit;
    std::vector<std::vector<std::uint32_t>> nodesOf(axes_.size());
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const RsmlAxis& axis = axes_[i];
      const bool isLateral = axis.parent != std::string::npos && !nodesOf[axis.parent].empty() && !axis.points.empty();
      for (std::size_t k = 0; k < axis.points.size(); ++k) {
        RootSystem::Node node;
        node.place = axis.points[k];
        node.order = axis.order;
        node.axis = static_cast<std::uint32_t>(i);
        node.radius = axis.diameters.empty() ? 0.0 : 0.5 * axis.diameters[k];
        if (!axis.emergences.empty()) {
          node.emergence = axis.emergences[k];
        }
        if (k == 0 && isLateral) {
          node.parent = joinOf(roots, axis, nodesOf[axis.parent]);
          noteGap(axis, axes_[axis.parent].points, core::length(roots.nodes[node.parent].place - node.place));
          if (roots.nodes[node.parent].place == node.place) {
            // the lateral begins at the point itself
            nodesOf[i].push_back(node.parent);
            continue;
          }
        } else if (k > 0) {
          node.parent = nodesOf[i].back();
        }
        nodesOf[i].push_back(static_cast<std::uint32_t>(roots.nodes.size()));
        roots.nodes.push_back(node);
      }
    }
    if (wrongJoins_ > 0) {
      roots.remark =
          std::to_string(wrongJoins_) + (wrongJoins_ == 1 ? " lateral begins" : " laterals begin") +
          " at the nearest point of the parent, because the file names a point that is not there: " + firstWrongJoin_;
    }
    const auto isLeftOut = [](const RsmlAxis& axis) { return axis.points.empty(); };
    if (const auto count = std::ranges::count_if(axes_, isLeftOut); count > 0) {
      roots.remark += (roots.remark.empty() ? "" : "; ") + std::to_string(count) +
                      (count == 1 ? " root has no points of a polyline and is left out: line "
                                  : " roots have no points of a polyline and are left out: line ") +
                      std::to_string(std::ranges::find_if(axes_, isLeftOut)->line);
    }
    if (gaps_ > 0) {
      roots.remark +=
          (roots.remark.empty() ? "" : "; ") + std::to_string(gaps_) +
          (gaps_ == 1 ? " lateral begins" : " laterals begin") +
          " farther from the parent than the parent's points lie apart; a straight piece joins them: " + firstGap_;
    }
    if (looks_ > kMostLooks) {
      return tl::unexpected(std::string(
          "laterals have no 'parent-node', and their parents have too many points to look for it. Add the property"));
    }
    return roots;
  }

 private:
  /// The node of an axis from which a lateral grows.
  [[nodiscard]] std::uint32_t joinOf(const RootSystem& roots, const RsmlAxis& lateral,
                                     const std::vector<std::uint32_t>& nodesOfParent) {
    // -1: unknown
    if (const double wanted = lateral.parentNode.value_or(-1.0); wanted != -1.0) {
      if (wanted >= 0.0 && wanted < static_cast<double>(nodesOfParent.size()) && wanted == std::floor(wanted)) {
        return nodesOfParent[static_cast<std::size_t>(wanted)];
      }
      if (wrongJoins_++ == 0) {
        core::appendNumber(firstWrongJoin_, wanted, core::NumberStyle::Shortest);
        firstWrongJoin_ = "line " + std::to_string(lateral.line) + " has the parent-node " + firstWrongJoin_ +
                          ", and the parent has the points 0 to " + std::to_string(nodesOfParent.size() - 1);
      }
    }
    std::uint32_t best = nodesOfParent.front();
    looks_ += nodesOfParent.size();
    if (looks_ > kMostLooks) {
      return best;
    }
    for (const std::uint32_t node : nodesOfParent) {
      if (core::length(roots.nodes[node].place - lateral.points.front()) <
          core::length(roots.nodes[best].place - lateral.points.front())) {
        best = node;
      }
    }
    return best;
  }

  /// Counts a lateral that begins away from its parent.
  void noteGap(const RsmlAxis& lateral, const std::vector<core::Vec3>& parent, double distance) {
    double apart = 0.0;
    for (std::size_t k = 1; k < parent.size() && !(apart >= distance); ++k) {
      apart = std::max(apart, core::length(parent[k] - parent[k - 1]));
    }
    if (parent.size() > 1 && distance > apart && gaps_++ == 0) {
      core::appendNumber(firstGap_, distance, core::NumberStyle::Shortest);
      firstGap_ = "line " + std::to_string(lateral.line) + ", " + firstGap_ + " away";
    }
  }

  std::span<const RsmlAxis> axes_;  // of the caller; parents come first
  std::size_t wrongJoins_ = 0;      // laterals whose parent-node is not there
  std::string firstWrongJoin_;
  std::size_t gaps_ = 0;  // laterals that begin away from their parents
  std::string firstGap_;
  std::uint64_t looks_ = 0;
};

}  // namespace

tl::expected<RootSystem, std::string> joinAxes(std::span<const RsmlAxis> axes, const std::string& unit) {
  return AxisJoin(axes).joined(unit);
}

}  // namespace espalier::roots

#include "clients/espalier/roots/rsml_axes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/core/number_text.h"

namespace espalier::roots {

namespace {

/// Points that are looked at to find where laterals begin, in all. A file of people needs a small part of it.
constexpr std::uint64_t kMostLooks = 1'000'000'000;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

class AxisJoin {
 public:
  explicit AxisJoin(std::vector<RsmlAxis> axes) : axes_(std::move(axes)) {}

  [[nodiscard]] tl::expected<RootSystem, std::string> joined(const std::string& unit) {
    RootSystem roots;
    roots.unit = unit;
    std::vector<std::vector<std::uint32_t>> nodesOf(axes_.size());
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      RsmlAxis& axis = axes_[i];
      RootSystem::Axis& known = roots.axes.emplace_back();
      known.id = std::move(axis.id);
      known.label = std::move(axis.label);
      known.plant = axis.plant;
      known.firstDiameter = axis.diameters.empty() ? kUnknown : axis.diameters.front();
      known.firstDay = axis.emergences.empty() ? kUnknown : axis.emergences.front();
      bool hasLength = false;
      const bool isLateral = axis.parent != std::string::npos && !nodesOf[axis.parent].empty() && !axis.points.empty();
      for (std::size_t k = 0; k < axis.points.size(); ++k) {
        RootSystem::Node node;
        node.place = axis.points[k];
        node.order = axis.order;
        node.axis = static_cast<std::uint32_t>(i);
        node.hasDiameter = !axis.diameters.empty() && !std::isnan(axis.diameters[k]);
        node.radius = node.hasDiameter ? 0.5 * axis.diameters[k] : 0.0;
        if (!axis.emergences.empty()) {
          node.emergence = axis.emergences[k];
        }
        if (k == 0 && isLateral) {
          known.parent = static_cast<std::uint32_t>(axis.parent);
          known.parentNode = joinOf(roots, axis, nodesOf[axis.parent]);
          node.parent = nodesOf[axis.parent][known.parentNode];
          noteGap(roots, axis, nodesOf[axis.parent], core::length(roots.nodes[node.parent].place - node.place));
          if (roots.nodes[node.parent].place == node.place) {
            // the lateral begins at the point itself
            known.hasFirstNode = false;
            nodesOf[i].push_back(node.parent);
            continue;
          }
        } else if (k > 0) {
          node.parent = nodesOf[i].back();
        }
        hasLength = hasLength || (node.parent != RootSystem::kNone && !(roots.nodes[node.parent].place == node.place));
        nodesOf[i].push_back(static_cast<std::uint32_t>(roots.nodes.size()));
        roots.nodes.push_back(node);
      }
      isEmpty_.push_back(axis.points.empty());
      if (!axis.points.empty() && !hasLength && withoutLength_++ == 0) {
        firstWithoutLength_ = axis.line;
      }
      axis.points = {};
      axis.diameters = {};
      axis.emergences = {};
    }
    if (wrongJoins_ > 0) {
      roots.remark =
          std::to_string(wrongJoins_) + (wrongJoins_ == 1 ? " lateral begins" : " laterals begin") +
          " at the nearest point of the parent, because the file names a point that is not there: " + firstWrongJoin_;
    }
    if (farJoins_ > 0) {
      roots.remark += (roots.remark.empty() ? "" : "; ") + std::to_string(farJoins_) +
                      (farJoins_ == 1 ? " lateral begins" : " laterals begin") +
                      " at the nearest point of the parent, because the point that the file names is farther away than "
                      "the parent's points lie apart: line " +
                      std::to_string(firstFarJoin_);
    }
    if (const auto count = std::ranges::count(isEmpty_, true); count > 0) {
      roots.remark +=
          (roots.remark.empty() ? "" : "; ") + std::to_string(count) +
          (count == 1 ? " root has no points of a polyline and is left out: line "
                      : " roots have no points of a polyline and are left out: line ") +
          std::to_string(axes_[static_cast<std::size_t>(std::ranges::find(isEmpty_, true) - isEmpty_.begin())].line);
    }
    if (withoutLength_ > 0) {
      roots.remark += (roots.remark.empty() ? "" : "; ") + std::to_string(withoutLength_) +
                      (withoutLength_ == 1 ? " root has a single point or no length and is not drawn: line "
                                           : " roots have a single point or no length and are not drawn: line ") +
                      std::to_string(firstWithoutLength_);
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
  /// The point of an axis from which a lateral grows.
  [[nodiscard]] std::size_t joinOf(const RootSystem& roots, const RsmlAxis& lateral,
                                   const std::vector<std::uint32_t>& nodesOfParent) {
    const auto distanceTo = [&](std::size_t point) {
      return core::length(roots.nodes[nodesOfParent[point]].place - lateral.points.front());
    };
    // -1: unknown
    if (const double wanted = lateral.parentNode.value_or(-1.0); wanted != -1.0) {
      if (wanted >= 0.0 && wanted < static_cast<double>(nodesOfParent.size()) && wanted == std::floor(wanted)) {
        const auto named = static_cast<std::size_t>(wanted);
        if (!isApart(roots, nodesOfParent, distanceTo(named))) {
          return named;
        }
        // files that leave out the first points of a root still count them: the published ones of R-SWMS leave out two
        const std::size_t nearest = nearestOf(nodesOfParent.size(), distanceTo);
        if (isApart(roots, nodesOfParent, distanceTo(nearest))) {
          return named;
        }
        if (farJoins_++ == 0) {
          firstFarJoin_ = lateral.line;
        }
        return nearest;
      }
      if (wrongJoins_++ == 0) {
        core::appendNumber(firstWrongJoin_, wanted, core::NumberStyle::Shortest);
        firstWrongJoin_ = "line " + std::to_string(lateral.line) + " has the parent-node " + firstWrongJoin_ +
                          ", and the parent has the points 0 to " + std::to_string(nodesOfParent.size() - 1);
      }
    }
    return nearestOf(nodesOfParent.size(), distanceTo);
  }

  template <typename Distance>
  [[nodiscard]] std::size_t nearestOf(std::size_t points, const Distance& distanceTo) {
    std::size_t best = 0;
    looks_ += points;
    if (looks_ > kMostLooks) {
      return best;
    }
    double least = points > 0 ? distanceTo(best) : 0.0;
    for (std::size_t point = 1; point < points; ++point) {
      const double distance = distanceTo(point);
      if (distance < least) {
        least = distance;
        best = point;
      }
    }
    return best;
  }

  /// Whether a distance is longer than the pieces between the points of a root.
  [[nodiscard]] static bool isApart(const RootSystem& roots, const std::vector<std::uint32_t>& nodes, double distance) {
    double apart = 0.0;
    for (std::size_t k = 1; k < nodes.size() && !(apart >= distance); ++k) {
      apart = std::max(apart, core::length(roots.nodes[nodes[k]].place - roots.nodes[nodes[k - 1]].place));
    }
    return nodes.size() > 1 && distance > apart;
  }

  /// Counts a lateral that begins away from its parent.
  void noteGap(const RootSystem& roots, const RsmlAxis& lateral, const std::vector<std::uint32_t>& parent,
               double distance) {
    if (isApart(roots, parent, distance) && gaps_++ == 0) {
      core::appendNumber(firstGap_, distance, core::NumberStyle::Shortest);
      firstGap_ = "line " + std::to_string(lateral.line) + ", " + firstGap_ + " away";
    }
  }

  std::vector<RsmlAxis> axes_;  // parents come first; points and values are freed when they are joined
  std::vector<bool> isEmpty_;   // has no points (axes_)
  std::size_t wrongJoins_ = 0;  // laterals whose parent-node is not there
  std::string firstWrongJoin_;
  std::size_t farJoins_ = 0;      // laterals whose parent-node is far away, and another point is not
  std::size_t firstFarJoin_ = 0;  // line of the first of them
  std::size_t withoutLength_ = 0;
  std::size_t firstWithoutLength_ = 0;  // line of the first of them
  std::size_t gaps_ = 0;                // laterals that begin away from their parents
  std::string firstGap_;
  std::uint64_t looks_ = 0;
};

}  // namespace

tl::expected<RootSystem, std::string> joinAxes(std::vector<RsmlAxis> axes, const std::string& unit) {
  return AxisJoin(std::move(axes)).joined(unit);
}

}  // namespace espalier::roots

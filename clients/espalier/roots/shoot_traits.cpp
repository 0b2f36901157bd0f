#include "clients/espalier/roots/shoot_traits.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/number_text.h"

namespace espalier::roots {

namespace {

using Point = std::pair<double, double>;

/// Coordinates along x, y and z.
std::array<double, 3> alongAxes(const core::Vec3& place) {
  return {place.x, place.y, place.z};
}

/// The two horizontal axes.
std::array<std::size_t, 2> groundAxes(int up) {
  return {up == 0 ? 1U : 0U, up == 2 ? 1U : 2U};
}

/// The area of the convex hull of points in a plane, by the monotone chain of Andrew (1979).
double hullArea(std::vector<Point> points) {
  std::sort(points.begin(), points.end());
  std::vector<Point> hull;
  for (const bool isUpper : {false, true}) {
    const std::size_t begin = hull.size();
    for (const Point& point : points) {
      const auto turnsRight = [&] {
        const Point& a = hull[hull.size() - 2];
        const Point& b = hull.back();
        return (b.first - a.first) * (point.second - a.second) - (b.second - a.second) * (point.first - a.first) <= 0.0;
      };
      while (hull.size() >= begin + 2 && turnsRight()) {
        hull.pop_back();
      }
      hull.push_back(point);
    }
    if (!isUpper) {
      std::reverse(points.begin(), points.end());
    }
  }
  double twice = 0.0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point& next = hull[(i + 1) % hull.size()];
    twice += hull[i].first * next.second - hull[i].second * next.first;
  }
  return 0.5 * std::abs(twice);
}

}  // namespace

ShootTraits shootTraitsOf(const turtle::Geometry& geometry, int up, double ground) {
  const auto upright = static_cast<std::size_t>(up);
  const std::array<std::size_t, 2> axes = groundAxes(up);
  ShootTraits traits;
  double lowest = HUGE_VAL;
  for (const auto* points : {&geometry.start, &geometry.end, &geometry.vertices}) {
    for (const core::Vec3& point : *points) {
      lowest = std::min(lowest, alongAxes(point)[upright]);
    }
  }
  std::array<double, 3> low{HUGE_VAL, HUGE_VAL, HUGE_VAL};
  std::array<double, 3> high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  std::vector<Point> shadow;
  for (std::size_t organ = 0; organ < geometry.organs.size(); ++organ) {
    const turtle::GeometryKind kind = geometry.kind[organ];
    if (kind == turtle::GeometryKind::Ball || kind == turtle::GeometryKind::Cylinder) {
      continue;
    }
    ++traits.leafCount;
    for (std::size_t i = geometry.vertexOffset[organ]; i < geometry.vertexOffset[organ + 1]; ++i) {
      const std::array<double, 3> place = alongAxes(geometry.vertices[i]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], place[axis]);
        high[axis] = std::max(high[axis], place[axis]);
      }
      shadow.emplace_back(place[axes[0]], place[axes[1]]);
    }
    for (std::size_t i = geometry.triangleOffset[organ]; i < geometry.triangleOffset[organ + 1]; ++i) {
      const auto& [a, b, c] = geometry.triangles[i];
      const core::Vec3 across =
          core::cross(geometry.vertices[b] - geometry.vertices[a], geometry.vertices[c] - geometry.vertices[a]);
      const double length = core::length(across);
      if (!(length > 0.0)) {
        continue;
      }
      const double cosine = std::min(std::abs(alongAxes(across)[upright]) / length, 1.0);
      const double angle = core::acos(cosine) * 180.0 / std::numbers::pi;
      const auto group = std::min(static_cast<std::size_t>(angle / 10.0), ShootTraits::kClasses - 1);
      traits.leafArea += 0.5 * length;
      traits.inclination += 0.5 * length * angle;
      traits.inclinations[group] += 0.5 * length;
    }
  }
  if (traits.leafCount == 0) {
    return traits;
  }
  if (traits.leafArea > 0.0) {
    traits.inclination /= traits.leafArea;
    for (double& part : traits.inclinations) {
      part /= traits.leafArea;
    }
  }
  traits.base = low[upright] - lowest;
  traits.top = high[upright] - lowest;
  traits.crownWidths = {high[axes[0]] - low[axes[0]], high[axes[1]] - low[axes[1]]};
  traits.crownArea = hullArea(std::move(shadow));
  const double area = ground > 0.0 ? ground : traits.crownArea;
  traits.leafAreaIndex = area > 0.0 ? traits.leafArea / area : 0.0;
  return traits;
}

std::string shootTraitRows(const ShootTraits& traits, int up, const std::string& unit) {
  constexpr const char* kShare = "1";
  const std::string area = unit == "1" ? unit : unit + "^2";
  std::string rows;
  if (traits.leafCount == 0) {
    return rows;
  }
  const auto add = [&](const char* name, const std::string& order, double value, const std::string& of) {
    rows += std::string(name) + "\t" + order + "\t";
    core::appendNumber(rows, value, core::NumberStyle::Shortest);
    rows += "\t" + of + "\n";
  };
  add("leaf_number", "", static_cast<double>(traits.leafCount), kShare);
  add("leaf_area", "", traits.leafArea, area);
  add("leaf_area_index", "", traits.leafAreaIndex, kShare);
  add("leaf_inclination", "", traits.inclination, "degree");
  for (std::size_t group = 0; group < ShootTraits::kClasses; ++group) {
    add("leaf_angle", std::to_string(10 * group + 5), traits.inclinations[group], kShare);
  }
  add("crown_base", "", traits.base, unit);
  add("crown_top", "", traits.top, unit);
  for (std::size_t k = 0; k < 2; ++k) {
    add("crown_width", std::string(1, "xyz"[groundAxes(up)[k]]), traits.crownWidths[k], unit);
  }
  add("crown_area", "", traits.crownArea, area);
  return rows;
}

}  // namespace espalier::roots

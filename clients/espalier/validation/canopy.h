#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/turtle/scene/geometry.h"

namespace espalier::environment {

/// Leaves of one plant, each drawn by a module of its own: module 2i + 1 draws leaf i.
class Canopy {
 public:
  /// Numbers between 0 and 1, always the same.
  double random() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state_ >> 11U) * 0x1p-53;
  }

  void triangle(const core::Vec3& a, const core::Vec3& b, const core::Vec3& c, std::uint8_t colour = 0) {
    const auto base = static_cast<std::uint32_t>(geometry_->vertices.size());
    geometry_->vertices.insert(geometry_->vertices.end(), {a, b, c});
    geometry_->triangles.push_back({base, base + 1, base + 2});
    close(colour);
  }
  void rectangle(const core::Vec3& corner, const core::Vec3& first, const core::Vec3& second, std::uint8_t colour = 0) {
    const auto base = static_cast<std::uint32_t>(geometry_->vertices.size());
    geometry_->vertices.insert(geometry_->vertices.end(),
                               {corner, corner + first, corner + first + second, corner + second});
    geometry_->triangles.insert(geometry_->triangles.end(), {{base, base + 1, base + 2}, {base, base + 2, base + 3}});
    close(colour);
  }
  /// An equilateral leaf around a place, across a normal.
  void leaf(const core::Vec3& place, const core::Vec3& normal, double area) {
    const core::Vec3 start = std::abs(normal.x) < 0.6 ? core::Vec3{1, 0, 0} : core::Vec3{0, 1, 0};
    const core::Vec3 first = core::normalised(start - normal * core::dot(normal, start));
    const core::Vec3 second = core::cross(normal, first);
    const double radius = std::sqrt(area * 4.0 / (3.0 * std::sqrt(3.0)));
    const double turn = 2.0 * std::numbers::pi * random();
    const auto corner = [&](int k) {
      const double angle = turn + 2.0 * std::numbers::pi * k / 3.0;
      return place + (first * core::cos(angle) + second * core::sin(angle)) * radius;
    };
    triangle(corner(0), corner(1), corner(2));
  }
  core::Vec3 sphericalNormal() {
    const double height = 2.0 * random() - 1.0;
    const double angle = 2.0 * std::numbers::pi * random();
    const double width = std::sqrt(1.0 - height * height);
    return {width * core::cos(angle), height, width * core::sin(angle)};
  }
  /// A layer of leaves at random in a square plot from 0 to `side`, of a thickness, above the ground at 0.
  void layer(double side, double thick, double leafAreaIndex, std::size_t count, bool isHorizontal) {
    for (std::size_t i = 0; i < count; ++i) {
      const core::Vec3 place{side * random(), 0.5 + thick * random(), side * random()};
      leaf(place, isHorizontal ? core::Vec3{0, 1, 0} : sphericalNormal(),
           leafAreaIndex * side * side / static_cast<double>(count));
    }
  }
  /// A crown of leaves even in a sphere.
  void crown(const core::Vec3& centre, double radius, double leafArea, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const double distance = radius * core::pow(random(), 1.0 / 3.0);
      leaf(centre + sphericalNormal() * distance, sphericalNormal(), leafArea / static_cast<double>(count));
    }
  }

  [[nodiscard]] std::size_t count() const { return geometry_->kind.size(); }
  [[nodiscard]] std::shared_ptr<const turtle::Geometry> geometry() const { return geometry_; }

 private:
  void close(std::uint8_t colour) {
    geometry_->vertexOffset.push_back(geometry_->vertices.size());
    geometry_->triangleOffset.push_back(geometry_->triangles.size());
    geometry_->kind.push_back(turtle::GeometryKind::Polygon);
    geometry_->organs.plant.push_back(0);
    geometry_->organs.module.push_back(2 * geometry_->kind.size() - 1);
    geometry_->organs.symbol.push_back(1);
    geometry_->organs.colour.push_back(colour);
    geometry_->organs.branchOrder.push_back(0);
  }

  std::shared_ptr<turtle::Geometry> geometry_ = std::make_shared<turtle::Geometry>();
  std::uint64_t state_ = 1;
};

}  // namespace espalier::environment

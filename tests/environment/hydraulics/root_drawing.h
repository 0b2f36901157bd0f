#pragma once

#include <memory>
#include <vector>

#include "engine/turtle/scene/geometry.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment {

/// Plants of segments, each drawn by the module after the one before, and queries behind them.
class RootDrawing {
 public:
  /// Draws a segment and sends a query behind it.
  RootDrawing& segment(const core::Vec3& from, const core::Vec3& to, double width,
                       const std::vector<double>& parameters, std::uint32_t order = 0) {
    geometry_.start.push_back(from);
    geometry_.end.push_back(to);
    geometry_.startWidth.push_back(width);
    geometry_.endWidth.push_back(width);
    geometry_.segments.plant.push_back(plant_);
    geometry_.segments.module.push_back(module_++);
    geometry_.segments.symbol.push_back(1);
    geometry_.segments.colour.push_back(0);
    geometry_.segments.branchOrder.push_back(order);
    return query(to, parameters);
  }
  RootDrawing& query(const core::Vec3& place, const std::vector<double>& parameters) {
    batch_.add(place, parameters);
    batch_.batch().plant.back() = plant_;
    batch_.batch().module.back() = module_++;
    return *this;
  }
  /// A root straight down (y) in parts, a query behind each.
  RootDrawing& root(const core::Vec3& top, double length, std::size_t parts, double width,
                    const std::vector<double>& parameters) {
    core::Vec3 from = top;
    for (std::size_t i = 1; i <= parts; ++i) {
      const core::Vec3 to = top - core::Vec3{0, length * static_cast<double>(i) / static_cast<double>(parts), 0};
      segment(from, to, width, parameters);
      from = to;
    }
    return *this;
  }
  RootDrawing& nextPlant() {
    ++plant_;
    module_ = 0;
    return *this;
  }
  RootDrawing& pixels() {
    geometry_.areWidthsPixels = true;
    return *this;
  }
  [[nodiscard]] turtle::QueryBatch queries(double timeDays = 0.0) {
    batch_.batch().geometry = std::make_shared<turtle::Geometry>(geometry_);
    batch_.batch().timeDays = timeDays;
    return batch_.batch();
  }

 private:
  turtle::Geometry geometry_;
  QueryBuilder batch_;
  std::uint32_t plant_ = 0;
  std::uint64_t module_ = 0;
};

/// A world of centimetres, y up.
inline turtle::EnvironmentContext centimetres(double stepDurationDays = 1.0) {
  turtle::EnvironmentContext context;
  context.world.lengthUnit = "cm";
  context.world.stepDurationDays = stepDurationDays;
  return context;
}

/// The error of a step; empty: there is none.
inline std::string errorOf(turtle::EnvironmentProcess& process, const turtle::QueryBatch& queries) {
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  const auto error = process.step(queries, replies);
  return error ? error->message : "";
}

}  // namespace espalier::environment

#include "engine/turtle/interpretation/drawing.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <utility>

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr std::int32_t kDefaultStripCount = 4;

}  // namespace

Drawing::Drawing(Scene* scene, const files::ViewSettings& view, std::uint32_t plant)
    : scene_(scene), view_(&view), plant_(plant) {
  if (scene_ != nullptr) {
    scene_->lineStyle = view.lineStyle;
  }
}

void Drawing::line(TurtleState& state, const Vec3& start) {
  if (scene_ == nullptr) {
    return;
  }
  const bool isInsideCylinder = (!open_.empty() && open_.back().isCylinder) ||
                                (state.cylinder != kNoParent && state.cylinderOrder == state.branchOrder);
  if (isInsideCylinder) {
    return;
  }
  // a tapered line begins with the width at the end of the line that it continues on the same axis
  double startWidth = state.width;
  if (view_->hasTaperedLines && state.segment != kNoParent) {
    const Segment& parent = scene_->segments[state.segment];
    if (parent.branchOrder == state.branchOrder && parent.end == start) {
      startWidth = parent.endWidth;
    }
  }
  const auto index = static_cast<std::uint32_t>(scene_->segments.size());
  scene_->segments.push_back({.start = start,
                              .end = state.position,
                              .frame = state.frame,
                              .startWidth = startWidth,
                              .endWidth = state.width,
                              .colour = state.colour,
                              .plant = plant_,
                              .module = module_,
                              .branchOrder = state.branchOrder,
                              .parent = state.segment,
                              .texture = textureOf(state.texture)});
  state.segment = index;
}

std::int32_t Drawing::textureOf(std::int32_t id) const {
  const bool isThere = id >= 1 && static_cast<std::size_t>(id) <= view_->textures.size() &&
                       view_->textures[static_cast<std::size_t>(id) - 1].image != nullptr;
  return isThere ? id : 0;
}

CylinderPoint Drawing::pointOf(const TurtleState& state, std::int32_t stripCount) const {
  return {.position = state.position,
          .frame = state.frame,
          .width = state.width,
          .colour = state.colour,
          .contour = state.contour,
          .stripCount = std::clamp(stripCount, 1, 1000),
          .sideCount = state.contourSides,
          .startTangent = state.startTangent,
          .endTangent = state.endTangent,
          .hasSmoothRadius = state.hasSmoothRadius,
          .startRadiusTangent = state.startRadiusTangent,
          .endRadiusTangent = state.endRadiusTangent};
}

void Drawing::vertex(const TurtleState& state, std::int32_t stripCount) {
  if (scene_ == nullptr || open_.empty()) {
    return;
  }
  OpenShape& shape = open_.back();
  if (shape.isCylinder) {
    shape.cylinder.points.push_back(pointOf(state, stripCount > 0 ? stripCount : shape.stripCount));
  } else {
    shape.polygon.vertices.push_back(state.position);
  }
}

void Drawing::beginPolygon(const TurtleState& state) {
  if (scene_ == nullptr) {
    return;
  }
  OpenShape shape;
  shape.polygon.colour = state.colour;
  shape.polygon.plant = plant_;
  shape.polygon.module = module_;
  shape.polygon.branchOrder = state.branchOrder;
  shape.polygon.parent = state.segment;
  open_.push_back(std::move(shape));
}

void Drawing::beginCylinder(const TurtleState& state, std::int32_t type, std::int32_t stripCount) {
  if (scene_ == nullptr) {
    return;
  }
  OpenShape shape;
  shape.isCylinder = true;
  shape.stripCount = stripCount > 0 ? stripCount : kDefaultStripCount;
  shape.cylinder.curve = type >= 3 ? GeneralizedCylinder::Curve::BSpline : GeneralizedCylinder::Curve::Hermite;
  shape.cylinder.isClosed = type % 2 == 0;
  shape.cylinder.plant = plant_;
  shape.cylinder.module = module_;
  shape.cylinder.branchOrder = state.branchOrder;
  shape.cylinder.parent = state.segment;
  shape.cylinder.texture = textureOf(state.texture);
  shape.cylinder.points.push_back(pointOf(state, shape.stripCount));
  open_.push_back(std::move(shape));
}

void Drawing::endPolygon() {
  if (scene_ == nullptr || open_.empty()) {
    return;
  }
  OpenShape shape = std::move(open_.back());
  open_.pop_back();
  if (shape.isCylinder && shape.cylinder.points.size() >= 2) {
    scene_->cylinders.push_back(std::move(shape.cylinder));
  } else if (!shape.isCylinder && shape.polygon.vertices.size() >= 3) {
    scene_->polygons.push_back(std::move(shape.polygon));
  }
}

void Drawing::startAxisCylinder(TurtleState& state) {
  if (scene_ == nullptr) {
    return;
  }
  GeneralizedCylinder cylinder;
  cylinder.plant = plant_;
  cylinder.module = module_;
  cylinder.branchOrder = state.branchOrder;
  cylinder.parent = state.segment;
  cylinder.texture = textureOf(state.texture);
  cylinder.points.push_back(pointOf(state, kDefaultStripCount));
  state.cylinder = static_cast<std::uint32_t>(scene_->cylinders.size());
  state.cylinderOrder = state.branchOrder;
  scene_->cylinders.push_back(std::move(cylinder));
}

void Drawing::addAxisCylinderPoint(const TurtleState& state, std::int32_t stripCount) {
  if (scene_ == nullptr || state.cylinder == kNoParent) {
    return;
  }
  scene_->cylinders[state.cylinder].points.push_back(pointOf(state, stripCount > 0 ? stripCount : kDefaultStripCount));
}

void Drawing::endAxisCylinder(TurtleState& state, std::int32_t stripCount) {
  addAxisCylinderPoint(state, stripCount);
  state.cylinder = kNoParent;
}

void Drawing::ball(const TurtleState& state, Ball::Kind kind, double diameter) {
  if (scene_ == nullptr || !(diameter > 0.0) || !std::isfinite(diameter)) {
    return;
  }
  scene_->balls.push_back({.kind = kind,
                           .centre = state.position,
                           .frame = state.frame,
                           .diameter = diameter,
                           .colour = state.colour,
                           .plant = plant_,
                           .module = module_,
                           .branchOrder = state.branchOrder,
                           .parent = state.segment});
}

void Drawing::surface(const TurtleState& state, std::uint32_t index, bool isTriangleSurface, const Vec3& scale) {
  if (scene_ == nullptr || scale.x == 0.0 || scale.y == 0.0 || scale.z == 0.0) {
    return;
  }
  const int own = isTriangleSurface ? view_->triangleSurfaces[index].texture : view_->surfaces[index].texture;
  scene_->surfaces.push_back({.surface = index,
                              .isTriangleSurface = isTriangleSurface,
                              .position = state.position,
                              .frame = state.frame,
                              .scale = scale,
                              .colour = state.colour,
                              .texture = textureOf(own >= 0 ? own : state.texture),
                              .plant = plant_,
                              .module = module_,
                              .branchOrder = state.branchOrder,
                              .parent = state.segment});
}

void Drawing::label(const TurtleState& state, std::string text) {
  if (scene_ != nullptr) {
    scene_->labels.push_back({.position = state.position,
                              .text = std::move(text),
                              .colour = state.colour,
                              .plant = plant_,
                              .module = module_,
                              .branchOrder = state.branchOrder,
                              .parent = state.segment});
  }
}

void Drawing::startPatch(std::int32_t id) {
  if (scene_ != nullptr) {
    patches_[id] = OpenPatch{};
  }
}

void Drawing::setPatchPoint(const TurtleState& state, std::int32_t id, std::int32_t row, std::int32_t column) {
  const auto found = patches_.find(id);
  if (scene_ == nullptr || found == patches_.end() || row < 0 || row > 4 || column < 0 || column > 4) {
    return;
  }
  found->second.points[static_cast<std::size_t>(row * 5 + column)] = state.position;
  found->second.isZeroBased = found->second.isZeroBased || row == 0 || column == 0;
}

void Drawing::drawPatch(const TurtleState& state, std::int32_t id, std::int32_t subdivisionS,
                        std::int32_t subdivisionT) {
  const auto found = patches_.find(id);
  if (scene_ == nullptr || found == patches_.end()) {
    return;
  }
  // rows and columns are counted from 1 unless the model used a 0
  const std::size_t first = found->second.isZeroBased ? 0 : 1;
  Patch patch;
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 0; column < 4; ++column) {
      patch.points[row * 4 + column] = found->second.points[(row + first) * 5 + column + first];
    }
  }
  patch.subdivisionS = std::clamp(subdivisionS, 1, 100);
  patch.subdivisionT = std::clamp(subdivisionT, 1, 100);
  patch.colour = state.colour;
  patch.texture = textureOf(state.texture);
  patch.plant = plant_;
  patch.module = module_;
  patch.branchOrder = state.branchOrder;
  patch.parent = state.segment;
  scene_->patches.push_back(patch);
}

void Drawing::finish() {
  open_.clear();
  if (scene_ != nullptr) {
    std::erase_if(scene_->cylinders, [](const GeneralizedCylinder& c) { return c.points.size() < 2; });
  }
}

std::string formatLabel(std::string_view format, std::span<const double> numbers) {
  std::string text;
  std::size_t next = 0;
  for (std::size_t i = 0; i < format.size(); ++i) {
    if (format[i] != '%') {
      text.push_back(format[i]);
      continue;
    }
    if (i + 1 < format.size() && format[i + 1] == '%') {
      text.push_back('%');
      ++i;
      continue;
    }
    // flags, width and precision; anything else ends the conversion
    std::string conversion = "%";
    std::size_t k = i + 1;
    std::size_t digits = 0;
    while (k < format.size() && (std::string_view("-+ #0.").find(format[k]) != std::string_view::npos ||
                                 std::isdigit(static_cast<unsigned char>(format[k])) != 0)) {
      digits += std::isdigit(static_cast<unsigned char>(format[k])) != 0 ? 1U : 0U;
      conversion.push_back(format[k++]);
    }
    while (k < format.size() && (format[k] == 'l' || format[k] == 'h')) {
      ++k;
    }
    if (k >= format.size() || digits > 4 || std::count(conversion.begin(), conversion.end(), '.') > 1) {
      text.append(format.substr(i));
      return text;
    }
    const char type = format[k];
    i = k;
    if (next >= numbers.size()) {
      continue;
    }
    const double value = numbers[next++];
    std::array<char, 1500> buffer{};
    if (std::string_view("eEfFgG").find(type) != std::string_view::npos) {
      conversion.push_back(type);
      static_cast<void>(std::snprintf(buffer.data(), buffer.size(), conversion.c_str(), value));
    } else if (std::string_view("diuoxX").find(type) != std::string_view::npos) {
      conversion += std::string("ll") + (type == 'u' ? 'd' : type);
      const long long whole = std::abs(value) < 9e18 ? static_cast<long long>(value) : 0;
      static_cast<void>(std::snprintf(buffer.data(), buffer.size(), conversion.c_str(), whole));
    } else if (type == 'c' && value >= 32.0 && value < 127.0) {
      buffer[0] = static_cast<char>(value);
    }
    text.append(buffer.data());
  }
  return text;
}

}  // namespace espalier::turtle

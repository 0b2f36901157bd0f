#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <utility>

#include "clients/espalier/roots/root_system.h"
#include "engine/core/number_text.h"

namespace espalier::roots {

namespace {

/// When segments appear in a model, by node; empty: all are there from the start.
struct Appearance {
  std::vector<std::uint64_t> step;  // (nodes)
  std::uint64_t last = 0;           // step at which all are there
};

/// The most days from the first emergence to the last: each is a step that looks at all segments.
constexpr double kMostDays = 1'000'000.0;

/// The first and the last day of emergence; the first is above the last where none is known.
std::pair<double, double> daysOf(const RootSystem& roots) {
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for (const RootSystem::Node& node : roots.nodes) {
    if (!std::isnan(node.emergence)) {
      first = std::min(first, node.emergence);
      last = std::max(last, node.emergence);
    }
  }
  return {first, last};
}

/// One step a day up to the last emergence, and no segment appears before its parent. Step 0 is day 0, so that days
/// stay as they are when the roots are written again; it is the first day where that is below 0 or the last is too far
/// away.
Appearance appearanceOf(const RootSystem& roots) {
  const auto [first, last] = daysOf(roots);
  const double days = std::floor(last - first);
  if (!(days >= 1.0 && days <= kMostDays)) {
    return {};
  }
  const bool isFromZero = first >= 0.0 && last <= kMostDays;
  Appearance appearance{.step = {}, .last = static_cast<std::uint64_t>(isFromZero ? std::floor(last) : days)};
  for (const RootSystem::Node& node : roots.nodes) {
    const std::uint64_t parent = node.parent == RootSystem::kNone ? 0 : appearance.step[node.parent];
    appearance.step.push_back(
        std::isnan(node.emergence)
            ? parent
            : std::max(parent, appearance.last - static_cast<std::uint64_t>(std::floor(last - node.emergence))));
  }
  return appearance;
}

/// The string that draws the roots, and the nodes at which its lines end when they are wanted; with `appearance` a
/// segment that comes later is a module that waits for its step: W(steps,x,y,z,diameter,length,age,order), or
/// V(steps,age,order) without a length.
std::string textOf(const RootSystem& roots, const Appearance& appearance, std::vector<std::uint32_t>* lines = nullptr) {
  const auto& nodes = roots.nodes;
  std::vector<std::vector<std::uint32_t>> children(nodes.size());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent != RootSystem::kNone) {
      children[nodes[i].parent].push_back(i);
    }
  }
  // the child that continues an axis comes last and needs no brackets
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    std::stable_partition(children[i].begin(), children[i].end(),
                          [&](std::uint32_t child) { return nodes[child].axis != nodes[i].axis; });
  }
  double last = 0.0;
  for (const RootSystem::Node& node : nodes) {
    last = std::max(last, std::isnan(node.emergence) ? 0.0 : node.emergence);
  }
  std::string text;
  const auto add = [&](const char* name, std::initializer_list<double> values) {
    text += name;
    for (const double* value = values.begin(); value != values.end(); ++value) {
      text += value == values.begin() ? "(" : ",";
      core::appendNumber(text, *value, core::NumberStyle::Shortest);
    }
    text += ")";
  };
  struct Visit {
    std::uint32_t node;
    std::size_t next;  // child
    bool hasBracket;
  };
  for (std::uint32_t collar = 0; collar < nodes.size(); ++collar) {
    if (nodes[collar].parent != RootSystem::kNone) {
      continue;
    }
    text += "[";
    add("@M", {nodes[collar].place.x, nodes[collar].place.y, nodes[collar].place.z});
    std::vector<Visit> open{{collar, 0, true}};
    while (!open.empty()) {
      Visit& visit = open.back();
      if (visit.next == children[visit.node].size()) {
        text += visit.hasBracket ? "]" : "";
        open.pop_back();
        continue;
      }
      const std::uint32_t child = children[visit.node][visit.next++];
      // also a lateral at a tip, which continues no axis
      const bool isLateral =
          nodes[visit.node].parent != RootSystem::kNone && nodes[child].axis != nodes[visit.node].axis;
      const bool hasBracket = isLateral || visit.next < children[visit.node].size();
      const core::Vec3 way = nodes[child].place - nodes[visit.node].place;
      text += hasBracket ? "[" : "";
      const double length = core::length(way);
      const double diameter = 2.0 * nodes[child].radius;
      const auto order = static_cast<double>(nodes[child].order);
      const std::uint64_t step = appearance.step.empty() ? 0 : appearance.step[child];
      // the steps that are left make it as old as it is at the end
      const double known = std::isnan(nodes[child].emergence) ? 0.0 : last - nodes[child].emergence;
      const double age = appearance.step.empty() ? known : known - static_cast<double>(appearance.last - step);
      if (lines != nullptr && length > 0.0) {
        lines->push_back(child);
      }
      if (step == 0) {
        if (length > 0.0) {
          add("@R", {way.x, way.y, way.z});
          add("!", {diameter});
          add("F", {length});
        }
        add("?E", {age, order, 0, 0, 0, 0, 0, 0, 0, 0});
      } else if (length > 0.0) {
        add("W", {static_cast<double>(step), way.x, way.y, way.z, diameter, length, age, order});
      } else {
        add("V", {static_cast<double>(step), age, order});
      }
      open.push_back({child, 0, hasBracket});
    }
  }
  return text;
}

}  // namespace

turtle::RsmlLabels labelsOf(const RootSystem& roots) {
  turtle::RsmlLabels labels;
  if (roots.axes.empty()) {
    return labels;
  }
  const auto& nodes = roots.nodes;
  const Appearance appearance = appearanceOf(roots);
  labels.plants = roots.plants;
  for (const RootSystem::Axis& axis : roots.axes) {
    labels.roots.push_back({.id = axis.id,
                            .label = axis.label,
                            .plant = axis.plant,
                            .parent = axis.parent,
                            .parentNode = axis.parentNode,
                            .points = {}});
    if (!axis.hasFirstNode) {
      labels.roots.back().points.push_back(
          {.place = {}, .diameter = axis.firstDiameter, .day = axis.firstDay, .step = 0});
    }
  }
  std::vector<std::size_t> pointOf(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    auto& points = labels.roots[nodes[i].axis].points;
    pointOf[i] = points.size();
    points.push_back(
        {.place = nodes[i].place,
         .diameter = nodes[i].hasDiameter ? 2.0 * nodes[i].radius : std::numeric_limits<double>::quiet_NaN(),
         .day = nodes[i].emergence,
         .step = appearance.step.empty() ? 0 : appearance.step[i]});
  }
  // first points that are those of parents, which come first
  for (std::size_t i = 0; i < roots.axes.size(); ++i) {
    auto& points = labels.roots[i].points;
    if (!roots.axes[i].hasFirstNode) {
      const turtle::RsmlLabels::Point& joint = labels.roots[roots.axes[i].parent].points[roots.axes[i].parentNode];
      points.front().place = joint.place;
      points.front().step = points.size() > 1 ? points[1].step : joint.step;
    }
    if (points.size() > 1 && std::isnan(points.front().day)) {
      points.front().day = points[1].day;
    }
  }
  std::vector<std::uint32_t> lines;
  textOf(roots, appearance, &lines);
  for (const std::uint32_t node : lines) {
    labels.pieces.push_back({.root = nodes[node].axis, .point = pointOf[node]});
  }
  return labels;
}

std::string stringOf(const RootSystem& roots) {
  return textOf(roots, {});
}

std::optional<std::string> problemOfDays(const RootSystem& roots) {
  const auto [first, last] = daysOf(roots);
  if (first > last || last - first < kMostDays + 1.0) {
    return std::nullopt;
  }
  std::string days;
  core::appendNumber(days, std::floor(last - first), core::NumberStyle::Shortest);
  return "the times of emergence span " + days +
         " days, and an animation has a step a day, at most 1000000. Write them in days, or start a model from the "
         "file "
         "with --from, which shows the last day";
}

bool isRootFile(std::string_view fileName) {
  return fileName.ends_with(".rsml") || fileName.ends_with(".tsv");
}

std::string modelOf(const RootSystem& roots) {
  const Appearance appearance = appearanceOf(roots);
  if (appearance.last == 0) {
    return "Lsystem: 1\nderivation length: 1\nAxiom: " + stringOf(roots) + "\nendlsystem\n";
  }
  return "Lsystem: 1\nderivation length: " + std::to_string(appearance.last) + "\nAxiom: " + textOf(roots, appearance) +
         "\nW(t,x,y,z,w,l,a,o) : t > 1 --> W(t-1,x,y,z,w,l,a,o)\n"
         "W(t,x,y,z,w,l,a,o) : t <= 1 --> @R(x,y,z)!(w)F(l)?E(a,o,0,0,0,0,0,0,0,0)\n"
         "V(t,a,o) : t > 1 --> V(t-1,a,o)\nV(t,a,o) : t <= 1 --> ?E(a,o,0,0,0,0,0,0,0,0)\n"
         "?E(a,o,c,d,e,f,g,h,i,j) --> ?E(a+1,o,c,d,e,f,g,h,i,j)\nendlsystem\n";
}

}  // namespace espalier::roots

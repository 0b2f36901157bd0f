#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>

#include "clients/espalier/roots/root_system.h"
#include "engine/core/number_text.h"

namespace espalier::roots {

namespace {

std::string placeOf(std::size_t line) {
  return "line " + std::to_string(line) + ": ";
}

std::string textOf(double number) {
  constexpr double kMostWhole = 1e15;  // below it a whole number is written without an exponent
  if (std::abs(number) < kMostWhole) {
    return std::to_string(static_cast<long long>(number));
  }
  std::string text;
  core::appendNumber(text, number, core::NumberStyle::Shortest);
  return text;
}

std::optional<double> numberOf(std::string_view field) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size() && std::isfinite(value) ? std::optional(value)
                                                                                            : std::nullopt;
}

std::vector<std::string_view> fieldsAt(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0;;) {
    const std::size_t end = line.find('\t', begin);
    fields.push_back(line.substr(begin, end == std::string_view::npos ? end : end - begin));
    if (end == std::string_view::npos) {
      return fields;
    }
    begin = end + 1;
  }
}

/// A row of a table of nodes as it is written.
struct TableNode {
  std::size_t line = 0;
  double id = 0.0;
  double parent = -1.0;
  RootSystem::Node node;
};

/// Puts parents before their children and replaces names by indices.
tl::expected<RootSystem, std::string> sorted(const std::vector<TableNode>& rows) {
  std::unordered_map<double, std::size_t> rowOf;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (!rowOf.try_emplace(rows[row].id, row).second) {
      return tl::unexpected(placeOf(rows[row].line) + "the node " + textOf(rows[row].id) +
                            " is there twice. Give each node a number of its own");
    }
  }
  RootSystem roots;
  std::vector<std::uint32_t> indexOf(rows.size(), RootSystem::kNone);
  std::vector<std::size_t> way;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    // up to a node that has its place already
    way.clear();
    for (std::size_t at = row; indexOf[at] == RootSystem::kNone;) {
      way.push_back(at);
      if (way.size() > rows.size()) {
        return tl::unexpected(placeOf(rows[at].line) + "the node " + textOf(rows[at].id) +
                              " is its own ancestor. Let parents lead to a collar, whose parent is -1");
      }
      if (rows[at].parent < 0.0) {
        break;
      }
      const auto parent = rowOf.find(rows[at].parent);
      if (parent == rowOf.end()) {
        return tl::unexpected(placeOf(rows[at].line) + "the node " + textOf(rows[at].id) + " has the parent " +
                              textOf(rows[at].parent) + ", which is not in the file. Add it, or write -1 for a collar");
      }
      at = parent->second;
    }
    for (; !way.empty(); way.pop_back()) {
      RootSystem::Node node = rows[way.back()].node;
      if (rows[way.back()].parent >= 0.0) {
        node.parent = indexOf[rowOf.at(rows[way.back()].parent)];
      }
      indexOf[way.back()] = static_cast<std::uint32_t>(roots.nodes.size());
      roots.nodes.push_back(node);
    }
  }
  return roots;
}

/// Numbers the axes: the first child of a point's order continues its axis, the others begin new ones.
void numberAxes(RootSystem& roots) {
  std::uint32_t count = 0;
  std::vector<std::uint8_t> isContinued(roots.nodes.size(), 0);
  for (RootSystem::Node& node : roots.nodes) {
    if (node.parent == RootSystem::kNone) {
      continue;
    }
    const RootSystem::Node& parent = roots.nodes[node.parent];
    const bool continues =
        parent.parent != RootSystem::kNone && parent.order == node.order && isContinued[node.parent] == 0;
    isContinued[node.parent] = continues ? 1 : isContinued[node.parent];
    node.axis = continues ? parent.axis : count++;
  }
}

}  // namespace

tl::expected<RootSystem, std::string> readRootTable(std::string_view text) {
  std::map<std::string, std::size_t, std::less<>> columns;
  std::vector<TableNode> rows;
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = text.substr(begin, end - begin);
    begin = end + 1;
    ++number;
    line = !line.empty() && line.back() == '\r' ? line.substr(0, line.size() - 1) : line;
    if (line.empty() || line.front() == '#') {
      continue;
    }
    const auto fields = fieldsAt(line);
    if (columns.empty()) {
      for (std::size_t i = 0; i < fields.size(); ++i) {
        columns.emplace(fields[i], i);
      }
      for (const char* name : {"node", "parent", "x", "y", "z"}) {
        if (!columns.contains(name)) {
          return tl::unexpected(placeOf(number) + "the header has no column '" + name +
                                "'. A table of roots has the columns node, parent, x, y, z, separated by tabs");
        }
      }
      continue;
    }
    TableNode row;
    row.line = number;
    double order = 1.0;
    for (const auto& [name, target] : {std::pair<std::string_view, double*>{"node", &row.id},
                                       {"parent", &row.parent},
                                       {"x", &row.node.place.x},
                                       {"y", &row.node.place.y},
                                       {"z", &row.node.place.z},
                                       {"radius", &row.node.radius},
                                       {"order", &order},
                                       {"emergence", &row.node.emergence}}) {
      const auto column = columns.find(name);
      if (column == columns.end()) {
        continue;
      }
      const std::string_view field = column->second < fields.size() ? fields[column->second] : std::string_view();
      const auto value = numberOf(field);
      if (!value) {
        return tl::unexpected(placeOf(number) + "expected a number in the column '" + std::string(name) + "', found '" +
                              std::string(field.substr(0, 40)) + "'. Write a number there, with a decimal point");
      }
      *target = *value;
    }
    if (row.node.radius < 0.0 || !(order >= 1.0 && order <= 1000.0)) {
      return tl::unexpected(placeOf(number) +
                            (row.node.radius < 0.0 ? "a radius is below 0" : "an order is not from 1 to 1000") +
                            ". Correct the number");
    }
    const core::Vec3& place = row.node.place;
    if (std::max({std::abs(place.x), std::abs(place.y), std::abs(place.z)}) > kLargestCoordinate) {
      return tl::unexpected(placeOf(number) + "a coordinate is beyond 1e100. Correct the number");
    }
    row.node.order = static_cast<std::uint32_t>(order);
    rows.push_back(row);
  }
  if (rows.empty()) {
    return tl::unexpected(std::string("the file has no nodes. Give a table with a header and a row for each node"));
  }
  auto roots = sorted(rows);
  if (roots) {
    numberAxes(*roots);
  }
  return roots;
}

tl::expected<RootSystem, std::string> readRoots(const std::string& fileName, std::string_view text) {
  auto roots = fileName.ends_with(".rsml") ? readRsml(text) : readRootTable(text);
  if (!roots) {
    return roots;
  }
  std::size_t early = 0;
  for (const RootSystem::Node& node : roots->nodes) {
    early += node.parent != RootSystem::kNone && node.emergence < roots->nodes[node.parent].emergence ? 1 : 0;
  }
  if (early > 0) {
    roots->remark += (roots->remark.empty() ? "" : "; ") + std::to_string(early) +
                     (early == 1 ? " point emerges before the point that it grows from, and is shown with it"
                                 : " points emerge before the points that they grow from, and are shown with them");
  }
  return roots;
}

RootSystem rootsOf(const turtle::Scene& scene) {
  RootSystem roots;
  std::vector<std::uint32_t> nodeOf(scene.segments.size());
  for (std::size_t i = 0; i < scene.segments.size(); ++i) {
    const turtle::Segment& segment = scene.segments[i];
    RootSystem::Node node;
    node.radius = 0.5 * segment.endWidth;
    node.order = segment.branchOrder + 1;
    if (segment.parent == turtle::kNoParent) {
      node.place = segment.start;
      roots.nodes.push_back(node);
      node.parent = static_cast<std::uint32_t>(roots.nodes.size() - 1);
    } else {
      node.parent = nodeOf[segment.parent];
    }
    node.place = segment.end;
    nodeOf[i] = static_cast<std::uint32_t>(roots.nodes.size());
    roots.nodes.push_back(node);
  }
  numberAxes(roots);
  return roots;
}

tl::expected<RootSystem, std::string> joinSeries(std::vector<DatedRoots> series) {
  const std::string& unit = series.back().roots.unit;
  std::map<std::array<double, 3>, double> firstDays;
  for (const auto& [day, roots] : series) {
    if (roots.unit != unit) {
      return tl::unexpected("the files have different units: '" + roots.unit + "' and '" + unit +
                            "'. Write all in one unit");
    }
    for (const RootSystem::Node& node : roots.nodes) {
      firstDays.try_emplace({node.place.x, node.place.y, node.place.z}, day);
    }
  }
  RootSystem last = std::move(series.back().roots);
  for (RootSystem::Node& node : last.nodes) {
    node.emergence = firstDays.at({node.place.x, node.place.y, node.place.z});
  }
  return last;
}

std::optional<std::string> convertTo(RootSystem& roots, const std::string& unit) {
  constexpr std::pair<std::string_view, double> kMetres[] = {{"m", 1.0},   {"dm", 0.1},  {"cm", 0.01},    {"mm", 0.001},
                                                             {"um", 1e-6}, {"nm", 1e-9}, {"inch", 0.0254}};
  if (roots.unit.empty() || roots.unit == unit) {
    return std::nullopt;
  }
  const auto metresOf = [&](std::string_view name) -> std::optional<double> {
    const auto* const known = std::ranges::find(kMetres, name, &std::pair<std::string_view, double>::first);
    return known == std::end(kMetres) ? std::nullopt : std::optional(known->second);
  };
  const auto from = metresOf(roots.unit);
  const auto to = metresOf(unit);
  if (!from || !to) {
    return "its lengths in '" + roots.unit + "' cannot be converted to those of the world in '" + unit +
           "'. Write its lengths in m, dm, cm, mm, um, nm or inch, and those of the world (lengthUnit) in m, dm, cm or "
           "mm";
  }
  const double factor = *from / *to;
  for (RootSystem::Node& node : roots.nodes) {
    node.place = node.place * factor;
    node.radius *= factor;
  }
  roots.unit = unit;
  return std::nullopt;
}

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

/// The string that draws the roots; with `appearance` a segment that comes later is a module that waits for its step:
/// W(steps,x,y,z,diameter,length,age,order), or V(steps,age,order) without a length.
std::string textOf(const RootSystem& roots, const Appearance& appearance) {
  const auto& nodes = roots.nodes;
  std::vector<std::vector<std::uint32_t>> children(nodes.size());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent != RootSystem::kNone) {
      children[nodes[i].parent].push_back(i);
    }
  }
  // what continues an axis comes last and needs no brackets
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

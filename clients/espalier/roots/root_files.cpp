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

bool RootSystem::hasLines() const {
  return std::ranges::any_of(
      nodes, [&](const Node& node) { return node.parent != kNone && !(nodes[node.parent].place == node.place); });
}

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
        if (!columns.emplace(fields[i], i).second) {
          return tl::unexpected(placeOf(number) + "the header has the column '" + std::string(fields[i].substr(0, 40)) +
                                "' twice. Give each column a name of its own");
        }
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
    if (row.node.radius < 0.0 || !(order >= 1.0 && order <= 1000.0 && order == std::floor(order))) {
      return tl::unexpected(
          placeOf(number) +
          (row.node.radius < 0.0 ? "a radius is below 0" : "an order is no whole number from 1 to 1000") +
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

tl::expected<RootSystem, std::string> readRoots(const std::string& fileName, std::string_view text,
                                                std::size_t mostPoints) {
  auto roots = fileName.ends_with(".rsml") ? readRsml(text, mostPoints) : readRootTable(text);
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
  std::vector<std::uint32_t> orderOfCollar(scene.segments.size());  // brackets around the segment at the collar
  for (std::size_t i = 0; i < scene.segments.size(); ++i) {
    const turtle::Segment& segment = scene.segments[i];
    RootSystem::Node node;
    node.radius = 0.5 * segment.endWidth;
    orderOfCollar[i] = segment.parent == turtle::kNoParent ? segment.branchOrder : orderOfCollar[segment.parent];
    node.order = segment.branchOrder - orderOfCollar[i] + 1;
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
  // its first point comes with its first segment
  for (RootSystem::Axis& axis : last.axes) {
    axis.firstDay = std::numeric_limits<double>::quiet_NaN();
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
  // one unit is a whole number of the other but for inches; a division by it rounds once, so 7 cm are 0.07 m
  const bool isSmaller = *from < *to;
  double ratio = isSmaller ? *to / *from : *from / *to;
  const double whole = std::round(ratio);
  ratio = std::abs(ratio - whole) < 1e-9 * whole ? whole : ratio;
  const auto convert = [&](double& length) { length = isSmaller ? length / ratio : length * ratio; };
  for (RootSystem::Node& node : roots.nodes) {
    for (double* const length : {&node.place.x, &node.place.y, &node.place.z, &node.radius}) {
      convert(*length);
    }
  }
  for (RootSystem::Axis& axis : roots.axes) {
    convert(axis.firstDiameter);
  }
  roots.unit = unit;
  return std::nullopt;
}

}  // namespace espalier::roots

#include "clients/espalier/forest/tree_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "engine/core/elementary.h"
#include "engine/core/number_text.h"

namespace espalier::command {

double TreePoints::height() const {
  if (points.empty()) {
    return 0.0;
  }
  const auto [low, high] = std::minmax_element(
      points.begin(), points.end(), [](const TreePoint& a, const TreePoint& b) { return a.position.y < b.position.y; });
  return high->position.y - low->position.y;
}

double TreePoints::radius() const {
  double result = 0.0;
  for (const TreePoint& point : points) {
    result = std::max(result, core::hypot(point.position.x, point.position.z));
  }
  return result;
}

TreePoints treePointsOf(const turtle::Scene& scene) {
  const std::size_t count = scene.segments.size();
  // lines on the longest path from the start of a segment; children come after their parents
  std::vector<std::uint32_t> hops(count, 1);
  for (std::size_t i = count; i-- > 0;) {
    const std::uint32_t parent = scene.segments[i].parent;
    if (parent != turtle::kNoParent) {
      hops[parent] = std::max(hops[parent], hops[i] + 1);
    }
  }
  TreePoints tree;
  tree.points.reserve(2 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const turtle::Segment& segment = scene.segments[i];
    tree.points.push_back({segment.start, hops[i], segment.branchOrder});
    tree.points.push_back({segment.end, hops[i] - 1, segment.branchOrder});
  }
  return tree;
}

std::string writeTreePoints(const TreePoints& tree) {
  std::string text;
  for (const TreePoint& point : tree.points) {
    for (const double number : {point.position.x, point.position.y, point.position.z}) {
      core::appendNumber(text, number, core::NumberStyle::Shortest);
      text += ' ';
    }
    text += std::to_string(point.hopsToLeaf) + " " + std::to_string(point.branches) + "\n";
  }
  return text;
}

Result<TreePoints> readTreePoints(std::string_view text) {
  constexpr std::string_view kSeparators = " \t\r,;";
  constexpr double kMostHops = 4e9;
  TreePoints tree;
  std::size_t lineNumber = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    ++lineNumber;
    const std::string where = "line " + std::to_string(lineNumber) + ": ";
    std::array<double, 5> numbers{};
    std::size_t count = 0;
    while (true) {
      line.remove_prefix(std::min(line.find_first_not_of(kSeparators), line.size()));
      if (line.empty()) {
        break;
      }
      const std::string_view word = line.substr(0, line.find_first_of(kSeparators));
      const std::optional<double> number = core::parseNumber(word);
      if (!number || !std::isfinite(*number)) {
        return problem(where + "'" + std::string(word.substr(0, 40)) + "' is not a number");
      }
      if (count < numbers.size()) {
        numbers[count] = *number;
      }
      ++count;
      line.remove_prefix(word.size());
    }
    if (count == 0) {
      continue;
    }
    if (count != numbers.size()) {
      return problem(where +
                     "a point is five numbers: x y z, greatest distance to a leaf, branches to the root; found " +
                     std::to_string(count));
    }
    const auto isCount = [](double value) { return value >= 0.0 && value < kMostHops && value == std::floor(value); };
    if (!isCount(numbers[3]) || !isCount(numbers[4])) {
      return problem(where + "the distance to a leaf and the branches to the root are whole numbers from 0");
    }
    tree.points.push_back({{numbers[0], numbers[1], numbers[2]},
                           static_cast<std::uint32_t>(numbers[3]),
                           static_cast<std::uint32_t>(numbers[4])});
  }
  if (tree.points.empty()) {
    return problem("the file holds no points");
  }
  if (tree.points.size() % 2 != 0) {
    return problem("the file holds " + std::to_string(tree.points.size()) +
                   " points; their number must be even, because two points are a line");
  }
  return tree;
}

}  // namespace espalier::command

#include "clients/espalier/forest/tree_painting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/frame.h"

namespace espalier::command {
namespace {

struct Range {
  int low;
  int high;
};

struct ColourRange {
  Range red, green, blue;
};

// brown wood, green leaves, pale flowers; the report's ranges reach from orange wood to blue leaves
constexpr ColourRange kTrunk{{86, 122}, {66, 92}, {48, 66}};
constexpr ColourRange kBranch{{104, 138}, {80, 106}, {56, 76}};
constexpr ColourRange kLeaf{{54, 100}, {106, 158}, {38, 70}};
constexpr ColourRange kRed{{176, 214}, {64, 96}, {54, 84}};
constexpr ColourRange kBlue{{214, 236}, {214, 236}, {222, 246}};
constexpr ColourRange kPink{{214, 240}, {150, 186}, {170, 206}};
constexpr ColourRange kYellow{{214, 238}, {186, 212}, {70, 120}};
// groups 3 and 4 are the same in the report
constexpr std::array<std::array<ColourRange, 2>, ForestColours::kFlowerGroups> kFlowers{
    {{kRed, kBlue}, {kRed, kPink}, {kYellow, kBlue}, {kYellow, kBlue}}};
constexpr files::PaletteColour kGroundColour{122, 132, 84};
constexpr files::PaletteColour kSky{226, 234, 240};

// thickness of the trunk over the tree's height, of a branch over what it grows from, of an axis' tip over its base
constexpr double kTrunkThickness = 1.0 / 38.0;
constexpr double kBranchThickness = 0.5;
constexpr double kLeastThickness = 1.0 / 400.0;
constexpr double kTipThickness = 0.25;
// leaves over the height; where along it a leaf is widest
constexpr double kLeafThickness = 1.0 / 42.0;
constexpr double kLeafLength = 1.0 / 19.0;
constexpr int kFlowerShare = 8;  // percent of the leaves that are flowers
constexpr double kLeafWidest = 0.55;
// cosine of the bend from which two lines are one
constexpr double kStraight = 1.0 - 1e-9;

class PaintingDraws {
 public:
  PaintingDraws(std::uint64_t seed, std::uint32_t domain, std::uint64_t index)
      : random_(seed, 0), domain_(domain), index_(index) {}

  double uniform() { return random_.uniform(core::DrawDomain::Environment, domain_, index_, draw_++); }
  int below(int count) { return static_cast<int>(uniform() * count); }
  std::uint8_t within(const Range& range) {
    return static_cast<std::uint8_t>(range.low + below(range.high - range.low + 1));
  }

 private:
  core::CounterRandom random_;
  std::uint32_t domain_;
  std::uint64_t index_;
  std::uint32_t draw_ = 0;
};

constexpr std::uint32_t kColourDraws = 1;
constexpr std::uint32_t kTreeDraws = 2;

}  // namespace

ForestColours::ForestColours(std::uint64_t seed) {
  // turtle colour n is entry n of block 1
  auto& map = palette_.maps[1];
  palette_.maps[0].fill(kSky);
  PaintingDraws draws(seed, kColourDraws, 0);
  const auto shade = [&](std::int32_t colour, const ColourRange& range) {
    const std::uint8_t red = draws.within(range.red);
    const std::uint8_t green = draws.within(range.green);
    const std::uint8_t blue = draws.within(range.blue);
    map[static_cast<std::size_t>(colour)] = {red, green, blue};
  };
  map[0] = kSky;
  map[kGround] = kGroundColour;
  for (int i = 0; i < kTrunkShades; ++i) {
    shade(trunk(i), kTrunk);
  }
  for (int i = 0; i < kBranchShades; ++i) {
    shade(branch(i), kBranch);
  }
  for (int i = 0; i < kLeafShades; ++i) {
    shade(leaf(i), kLeaf);
  }
  for (int group = 0; group < kFlowerGroups; ++group) {
    for (int kind = 0; kind < 2; ++kind) {
      for (int i = 0; i < kFlowerShades; ++i) {
        shade(flower(group, kind, i), kFlowers[static_cast<std::size_t>(group)][static_cast<std::size_t>(kind)]);
      }
    }
  }
}

namespace {

// a line of a tree, with the axis that it is part of, from its base to its tip
struct TreeLine {
  core::Vec3 direction;
  std::uint32_t parent = turtle::kNoParent;  // line that it grows from
  std::uint32_t axis = 0;                    // number of its axis' first line
  double along = 0.0;                        // length of the axis before it
  double length = 0.0;
};

struct TreeLines {
  std::vector<TreeLine> lines;
  std::vector<double> axisLength;  // by the axis' first line (lineCount)
};

// a line continues the axis of the line that ends at its start, unless a branch opens there
TreeLines linesOf(const TreePoints& tree) {
  TreeLines result;
  const std::size_t count = tree.points.size() / 2;
  result.lines.resize(count);
  result.axisLength.assign(count, 0.0);
  std::vector<bool> isContinued(count, false);
  // by place and number of branches to the root: several lines may end at one place
  std::map<std::tuple<double, double, double, std::uint32_t>, std::uint32_t> ends;
  for (std::uint32_t i = 0; i < count; ++i) {
    const TreePoint& start = tree.points[2 * i];
    const TreePoint& end = tree.points[2 * i + 1];
    TreeLine& line = result.lines[i];
    const core::Vec3 along = end.position - start.position;
    line.length = core::length(along);
    line.direction = line.length > 0.0 ? along * (1.0 / line.length) : core::Vec3{0, 1, 0};
    line.axis = i;
    // the line of most branches that has not more than this one
    const auto [x, y, z] = start.position;
    const auto after = ends.upper_bound({x, y, z, end.branches});
    if (after != ends.begin() && std::prev(after)->first >= std::tuple(x, y, z, 0U)) {
      line.parent = std::prev(after)->second;
      const TreeLine& before = result.lines[line.parent];
      if (tree.points[2 * line.parent + 1].branches == end.branches && !isContinued[line.parent]) {
        isContinued[line.parent] = true;
        line.axis = before.axis;
        line.along = before.along + before.length;
      }
    }
    result.axisLength[line.axis] = std::max(result.axisLength[line.axis], line.along + line.length);
    ends[{end.position.x, end.position.y, end.position.z, end.branches}] = i;
  }
  return result;
}

/// The lines that are drawn already, by where they start.
class DrawnLines {
 public:
  void add(const core::Vec3& start, const core::Vec3& direction, double length, std::uint32_t segment) {
    lines_[{start.x, start.y, start.z}].push_back({direction, length, segment});
  }
  /// The segment of a drawn line that a line from there lies in.
  [[nodiscard]] std::optional<std::uint32_t> lineAround(const core::Vec3& start, const core::Vec3& direction,
                                                        double length) const {
    const auto found = lines_.find({start.x, start.y, start.z});
    if (found == lines_.end()) {
      return std::nullopt;
    }
    const auto around = std::ranges::find_if(found->second, [&](const Line& line) {
      return line.length >= length * kStraight && core::dot(line.direction, direction) > kStraight;
    });
    return around == found->second.end() ? std::nullopt : std::optional(around->segment);
  }

 private:
  struct Line {
    core::Vec3 direction;
    double length;
    std::uint32_t segment;
  };
  std::map<std::tuple<double, double, double>, std::vector<Line>> lines_;
};

// a blade along the line that ends the axis: a kite, widest past its middle
turtle::Polygon leafAlong(const core::Vec3& start, const core::Vec3& direction, double length, double width,
                          double turn) {
  const core::Vec3 other = std::abs(direction.y) < 0.9 ? core::Vec3{0, 1, 0} : core::Vec3{1, 0, 0};
  const core::Vec3 a = core::normalised(core::cross(direction, other));
  const core::Vec3 b = core::cross(direction, a);
  const core::Vec3 side = 0.5 * width * (core::cos(turn) * a + core::sin(turn) * b);
  const core::Vec3 middle = start + kLeafWidest * length * direction;
  turtle::Polygon leaf;
  leaf.vertices = {start, middle + side, start + length * direction, middle - side};
  return leaf;
}

// frames a line by its direction
void setFrame(turtle::Segment& segment, const core::Vec3& direction) {
  segment.frame.heading = direction;
  const core::Vec3 other = std::abs(direction.y) < 0.9 ? core::Vec3{0, 1, 0} : core::Vec3{1, 0, 0};
  segment.frame.up = core::normalised(core::cross(direction, other));
  segment.frame.left = core::cross(direction, segment.frame.up);
}

}  // namespace

turtle::Scene paintTree(const TreePoints& tree, std::uint64_t seed, std::uint32_t index) {
  PaintingDraws draws(seed, kTreeDraws, index);
  const std::int32_t trunk = ForestColours::trunk(draws.below(ForestColours::kTrunkShades));
  const std::int32_t branch = ForestColours::branch(draws.below(ForestColours::kBranchShades));
  const int group = draws.below(ForestColours::kFlowerGroups);
  const double height = tree.height();
  const TreeLines axes = linesOf(tree);

  turtle::Scene scene;
  scene.lineStyle = files::LineStyle::Cylinder;
  // the drawn line that each line became part of
  std::vector<std::uint32_t> drawnAs(axes.lines.size(), turtle::kNoParent);
  DrawnLines known;
  for (std::size_t i = 0; i < axes.lines.size(); ++i) {
    const TreeLine& line = axes.lines[i];
    const TreePoint& start = tree.points[2 * i];
    const TreePoint& end = tree.points[2 * i + 1];
    const std::uint32_t parent = line.parent == turtle::kNoParent ? turtle::kNoParent : drawnAs[line.parent];
    if (end.hopsToLeaf == 0) {
      const int kind = draws.below(200 / kFlowerShare);
      const double length = std::max(line.length, height * kLeafLength);
      turtle::Polygon leaf = leafAlong(start.position, line.direction, length, height * kLeafThickness,
                                       2.0 * std::numbers::pi * draws.uniform());
      leaf.colour = kind < 2 ? ForestColours::flower(group, kind, draws.below(ForestColours::kFlowerShades))
                             : ForestColours::leaf(draws.below(ForestColours::kLeafShades));
      leaf.branchOrder = end.branches;
      leaf.module = i;
      leaf.parent = parent;
      scene.polygons.push_back(std::move(leaf));
      continue;
    }
    // a branch without a turn lies in the line that it grows beside
    if (const auto inside = known.lineAround(start.position, line.direction, line.length)) {
      drawnAs[i] = *inside;
      continue;
    }
    // thinner from the base of the axis to its tip
    const double base = height * std::max(kTrunkThickness * core::pow(kBranchThickness, end.branches), kLeastThickness);
    const auto widthAt = [&](double along) {
      return base * (1.0 - (1.0 - kTipThickness) * along / axes.axisLength[line.axis]);
    };
    const double endWidth = widthAt(line.along + line.length);
    if (parent != turtle::kNoParent) {
      // join a line with the line before it when both have the same direction
      turtle::Segment& before = scene.segments[parent];
      const bool goesOn = axes.lines[line.parent].axis == line.axis && before.end == start.position &&
                          core::dot(before.frame.heading, line.direction) > kStraight;
      if (goesOn) {
        before.end = end.position;
        before.endWidth = endWidth;
        drawnAs[i] = parent;
        known.add(start.position, line.direction, line.length, parent);
        continue;
      }
    }
    turtle::Segment segment;
    segment.start = start.position;
    segment.end = end.position;
    segment.startWidth = widthAt(line.along);
    segment.endWidth = endWidth;
    segment.branchOrder = end.branches;
    segment.module = i;
    segment.colour = end.branches == 0 ? trunk : branch;
    segment.parent = parent;
    setFrame(segment, line.direction);
    drawnAs[i] = static_cast<std::uint32_t>(scene.segments.size());
    known.add(start.position, line.direction, line.length, drawnAs[i]);
    scene.segments.push_back(segment);
  }
  return scene;
}

}  // namespace espalier::command

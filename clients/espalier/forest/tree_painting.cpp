#include "clients/espalier/forest/tree_painting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

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

// the report's ranges
constexpr ColourRange kTrunk{{51, 153}, {25, 76}, {0, 0}};
constexpr ColourRange kBranch{{204, 255}, {102, 204}, {0, 51}};
constexpr ColourRange kLeaf{{0, 178}, {51, 255}, {0, 178}};
constexpr ColourRange kRed{{102, 255}, {0, 204}, {0, 153}};
constexpr ColourRange kBlue{{0, 153}, {0, 255}, {102, 255}};
constexpr ColourRange kPink{{51, 255}, {0, 153}, {51, 255}};
constexpr ColourRange kYellow{{102, 255}, {102, 255}, {0, 153}};
// groups 3 and 4 are the same in the report
constexpr std::array<std::array<ColourRange, 2>, ForestColours::kFlowerGroups> kFlowers{
    {{kRed, kBlue}, {kRed, kPink}, {kYellow, kBlue}, {kYellow, kBlue}}};
constexpr language::PaletteColour kGroundColour{122, 132, 84};
constexpr language::PaletteColour kSky{226, 234, 240};

// thickness of the trunk over the tree's height, of a branch over what it grows from, of a leaf over the height
constexpr double kTrunkThickness = 1.0 / 36.0;
constexpr double kBranchThickness = 0.62;
constexpr double kLeafThickness = 1.0 / 140.0;
constexpr double kLeastThickness = 1.0 / 400.0;

class Draws {
 public:
  Draws(std::uint64_t seed, std::uint32_t domain, std::uint64_t index)
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
  Draws draws(seed, kColourDraws, 0);
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

turtle::Scene paintTree(const TreePoints& tree, std::uint64_t seed, std::uint32_t index) {
  Draws draws(seed, kTreeDraws, index);
  const std::int32_t trunk = ForestColours::trunk(draws.below(ForestColours::kTrunkShades));
  const std::int32_t branch = ForestColours::branch(draws.below(ForestColours::kBranchShades));
  const int group = draws.below(ForestColours::kFlowerGroups);
  const double height = tree.height();

  turtle::Scene scene;
  scene.lineStyle = language::LineStyle::Cylinder;
  scene.segments.reserve(tree.points.size() / 2);
  // a line goes on from the one that ends where it starts
  std::map<std::tuple<double, double, double>, std::uint32_t> ends;
  for (std::size_t i = 0; i + 1 < tree.points.size(); i += 2) {
    const TreePoint& start = tree.points[i];
    const TreePoint& end = tree.points[i + 1];
    turtle::Segment segment;
    segment.start = start.position;
    segment.end = end.position;
    segment.branchOrder = end.branches;
    segment.module = i / 2;
    const bool isLeaf = end.hopsToLeaf == 0;
    double width = height * kTrunkThickness * std::pow(kBranchThickness, end.branches);
    width = std::max(width, height * kLeastThickness);
    if (isLeaf) {
      width = height * kLeafThickness;
      const int kind = draws.below(10);
      segment.colour = kind < 2 ? ForestColours::flower(group, kind, draws.below(ForestColours::kFlowerShades))
                                : ForestColours::leaf(draws.below(ForestColours::kLeafShades));
    } else {
      segment.colour = end.branches == 0 ? trunk : branch;
    }
    segment.startWidth = segment.endWidth = width;
    const core::Vec3 along = end.position - start.position;
    const double length = core::length(along);
    if (length > 0.0) {
      segment.frame.heading = along * (1.0 / length);
      const core::Vec3 other = std::abs(segment.frame.heading.y) < 0.9 ? core::Vec3{0, 1, 0} : core::Vec3{1, 0, 0};
      segment.frame.up = core::normalised(core::cross(segment.frame.heading, other));
      segment.frame.left = core::cross(segment.frame.heading, segment.frame.up);
    }
    const auto parent = ends.find({start.position.x, start.position.y, start.position.z});
    segment.parent = parent == ends.end() ? turtle::kNoParent : parent->second;
    ends[{end.position.x, end.position.y, end.position.z}] = static_cast<std::uint32_t>(scene.segments.size());
    scene.segments.push_back(segment);
  }
  return scene;
}

}  // namespace espalier::command

#pragma once

#include <cstdint>

#include "clients/espalier/forest/tree_points.h"
#include "engine/core/random.h"
#include "engine/files/colour_files.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::command {

/// The colours of a whole forest, shades drawn from the ranges that Rodrigues, Coelho & Alencar 2018 print: trunks,
/// branches, leaves, and two flowers in each of four groups.
class ForestColours {
 public:
  explicit ForestColours(std::uint64_t seed);

  [[nodiscard]] const files::Palette& palette() const { return palette_; }
  /// What the ground looks like; ours.
  static constexpr std::int32_t kGround = 1;

  static constexpr int kTrunkShades = 6;
  static constexpr int kBranchShades = 6;
  static constexpr int kLeafShades = 10;
  static constexpr int kFlowerShades = 4;
  static constexpr int kFlowerGroups = 4;

  // turtle colours; `shade` counts from 0, `flower` is 0 or 1
  [[nodiscard]] static std::int32_t trunk(int shade) { return kGround + 1 + shade; }
  [[nodiscard]] static std::int32_t branch(int shade) { return trunk(kTrunkShades) + shade; }
  [[nodiscard]] static std::int32_t leaf(int shade) { return branch(kBranchShades) + shade; }
  [[nodiscard]] static std::int32_t flower(int group, int flower, int shade) {
    return leaf(kLeafShades) + (2 * group + flower) * kFlowerShades + shade;
  }

 private:
  files::Palette palette_;
};

/// A tree as the report draws it: lines to leaves (hops 0 at their end) are leaves of one thickness, of which a tenth
/// is the first and a tenth the second flower of the group drawn for the tree; the rest is as thick as its number of
/// branches and the tree's height say, trunk and branches in colours of their own. Ours: an axis gets thinner to its
/// tip, a leaf is a flat blade along its line (polygons, 4 corners), and what goes on straight is one line, so that a
/// forest is a small file. `index` tells trees of one forest apart. O(lines · log(lines)).
[[nodiscard]] turtle::Scene paintTree(const TreePoints& tree, std::uint64_t seed, std::uint32_t index);

}  // namespace espalier::command

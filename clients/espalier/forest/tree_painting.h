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
  /// The colour of the ground; not in the report.
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

/// A tree as the report draws it. The last line of an axis (hops 0 at its end) is a leaf; a tenth of the leaves is the
/// first flower and a tenth the second flower of the group of the tree. The thickness of other lines depends on the
/// number of branches and the height of the tree; trunk and branches have different colours. Our additions: an axis
/// gets thinner to its tip, a leaf is a flat blade along its line (polygons, 4 corners), and successive lines in the
/// same direction are one line, so that the file of a forest is small. `index` is the number of the tree in the forest.
/// O(lines · log(lines)).
[[nodiscard]] turtle::Scene paintTree(const TreePoints& tree, std::uint64_t seed, std::uint32_t index);

}  // namespace espalier::command

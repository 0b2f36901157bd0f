#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::command {

/// Ways to place the trees of a forest.
enum class Spacing : std::uint8_t {
  Grid,         // points of a square grid, each taken by one tree (Rodrigues, Coelho & Alencar 2018)
  Jittered,     // the same, each moved at random within the middle of its cell, so that no rows are visible
  Poisson,      // at random, no two nearer than the distance (Poisson disc; Cook 1986)
  Competition,  // the survivors of seedlings that grow and shade each other (Deussen et al. 1998)
};

/// A place for a tree.
struct TreePlace {
  core::Vec3 position;  // y = 0
  double turnRadians = 0.0;
  double size = 1.0;  // in competition the disc's radius over the largest one's, else 1
};

/// `count` different places about the origin. `distance` is the width of a grid cell (in a jittered grid two trees are
/// at least a fifth of it apart), the least distance of a Poisson disc, or in competition the mean width of the room of
/// a tree. A pure function of its arguments. In competition the process `ecosystem` decides in each of many steps which
/// seedlings are dominated and die.
[[nodiscard]] std::vector<TreePlace> layoutForest(Spacing spacing, std::size_t count, double distance,
                                                  std::uint64_t seed);

}  // namespace espalier::command

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::command {

/// Where the trees of a forest stand.
enum class Spacing : std::uint8_t {
  Grid,         // points of a square grid, each taken by one tree (Rodrigues, Coelho & Alencar 2018)
  Jittered,     // the same, each moved at random within the middle of its cell, so that no rows are seen
  Poisson,      // at random, no two nearer than the distance (Poisson disc; Cook 1986)
  Competition,  // what is left of more seedlings that grow and shade each other out (Deussen et al. 1998)
};

/// A place for a tree.
struct TreePlace {
  core::Vec3 position;  // y = 0
  double turnRadians = 0.0;
  double size = 1.0;  // in competition the disc's radius over the largest one's, else 1
};

/// `count` places about the origin, `distance` apart: the width of a grid's cell (of a jittered one a fifth of it at
/// least is between two), the least distance of a Poisson disc, in competition the mean width of what a tree has for
/// itself. No two are the same. A pure function of its arguments. In competition the process `ecosystem` says in each
/// of many steps who is dominated and dies.
[[nodiscard]] std::vector<TreePlace> layoutForest(Spacing spacing, std::size_t count, double distance,
                                                  std::uint64_t seed);

}  // namespace espalier::command

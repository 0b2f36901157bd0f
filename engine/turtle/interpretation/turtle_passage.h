#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

/// The turtle before and behind a part of a string. Where the same modules follow the same turtle again, they do the
/// same, wherever they are in the string.
struct TurtlePassage {
  TurtleState entry;                // before it
  std::vector<TurtleState> closed;  // at the branches open before it that it closes, the innermost first
  TurtleState exit;                 // after it; records count from the part's first, or are outer ones
  std::vector<TurtleState> opened;  // at the branches that it leaves open, the outermost first; records as above
  bool endsString = false;          // nothing was behind it
  std::uint64_t modules = 0;        // of the part
  std::uint64_t parameters = 0;     // of its modules
  std::uint32_t records = 0;        // that it gave

  /// Whether it would be the same for this turtle with these open branches (the outermost first), when so many modules
  /// are left of the string. Bits are compared; of records only whether there is one.
  [[nodiscard]] bool isSameFor(const TurtleState& turtle, std::span<const TurtleState> openBranches,
                               std::uint64_t modulesLeft) const;
  /// Whether the branches of `closed` from `first` on are the innermost of these open branches.
  [[nodiscard]] bool closesSame(std::size_t first, std::span<const TurtleState> openBranches) const;
};

}  // namespace espalier::turtle

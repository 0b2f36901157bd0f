#pragma once

#include <cstdint>
#include <vector>

#include "engine/language/program.h"
#include "engine/turtle/interpretation/turtle_command.h"

namespace espalier::turtle {

/// The properties of each module type of a Program that interpretation needs, computed once.
struct InterpretationTables {
  explicit InterpretationTables(const language::Program& program);

  /// The meaning of a module for the structure of the string.
  enum class Role : std::uint8_t { None, OpenBranch, CloseBranch, Call, SystemEnd };

  /// The output that a module can add, as bits. Of a group of modules (`@M(x,y)`) the first counts.
  static constexpr std::uint8_t kSegment = 1;
  static constexpr std::uint8_t kRecord = 2;

  // all by module type (moduleTypeCount)
  std::vector<TurtleCommand> commandOf;
  std::vector<Role> roleOf;
  std::vector<std::uint8_t> mayExpand;  // a homomorphism production begins with the type
  std::vector<std::uint8_t> isSkipped;  // it does nothing and stands for itself
  std::vector<std::uint8_t> adds;       // at most: of the bits above

  bool hasImages = false;               // any homomorphism production exists
  bool hasCut = false;                  // `%` or `@mc`: modules may be skipped
  bool hasIndependentBranches = false;  // a branch depends only on the turtle at its start
  bool mayDrawApart = false;            // the same for what it draws, if no polygon or cylinder is open there
};

}  // namespace espalier::turtle

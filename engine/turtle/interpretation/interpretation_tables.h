#pragma once

#include <cstdint>
#include <vector>

#include "engine/language/program.h"
#include "engine/turtle/interpretation/turtle_command.h"

namespace espalier::turtle {

/// What interpretation needs to know of each module type of a Program, looked up once.
struct InterpretationTables {
  explicit InterpretationTables(const language::Program& program);

  /// What a module means for the structure of the string.
  enum class Role : std::uint8_t { None, OpenBranch, CloseBranch, Call, SystemEnd };

  /// What a module adds to the output, as bits. Of a group of modules (`@M(x,y)`) the first counts.
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
  bool hasIndependentBranches = false;  // what a branch does depends on the turtle at its start alone
};

}  // namespace espalier::turtle

#include "engine/turtle/interpretation/interpretation_tables.h"

#include <algorithm>

#include "engine/turtle/interpretation/record_chain.h"

namespace espalier::turtle {
namespace {

using Role = InterpretationTables::Role;

// the most that a module of the command adds
std::uint8_t addedBy(TurtleCommand command) {
  using Tables = InterpretationTables;
  switch (command) {
    case TurtleCommand::DrawVertex:
    case TurtleCommand::Draw:
      return Tables::kSegment | Tables::kRecord;
    case TurtleCommand::MoveVertex:
    case TurtleCommand::Move:
    case TurtleCommand::PolygonEnd:
    case TurtleCommand::Surface:
    case TurtleCommand::At:
    case TurtleCommand::LegacyPosition:
    case TurtleCommand::Query:
      return Tables::kRecord;
    default:
      return 0;
  }
}

Role roleFor(const language::Program& program, core::ModuleTypeId type, TurtleCommand command) {
  if (type == program.openBranch) {
    return Role::OpenBranch;
  }
  if (type == program.closeBranch) {
    return Role::CloseBranch;
  }
  if (type == program.subSystemEnd) {
    return Role::SystemEnd;
  }
  return command == TurtleCommand::Query && program.arity[type] > 0 ? Role::Call : Role::None;
}

/// Whether each bracket of the string stands for itself and belongs to the other one of the string: an image closes the
/// branches that it opens, and no other.
bool keepsBrackets(const language::Program& program) {
  const auto isBracket = [&](core::ModuleTypeId type) {
    return type == program.openBranch || type == program.closeBranch;
  };
  const auto keeps = [&](const language::Production& production) {
    std::size_t open = 0;
    for (const language::SuccessorModule& module : production.successor) {
      if (module.type == program.closeBranch && open == 0) {
        return false;
      }
      open += module.type == program.openBranch ? 1 : 0;
      open -= module.type == program.closeBranch ? 1 : 0;
    }
    return open == 0 && !isBracket(production.predecessor.front().type);
  };
  return std::ranges::all_of(program.systems, [&](const language::LSystem& system) {
    return std::ranges::all_of(system.homomorphism.productions, keeps);
  });
}

}  // namespace

InterpretationTables::InterpretationTables(const language::Program& program) {
  const std::size_t typeCount = program.moduleTypeCount();
  mayExpand.resize(typeCount, 0);
  for (const language::LSystem& system : program.systems) {
    for (const language::Production& production : system.homomorphism.productions) {
      mayExpand[production.predecessor.front().type] = 1;
      hasImages = true;
    }
  }
  bool hasCalls = program.hasSubSystems;
  for (std::size_t i = 0; i < typeCount; ++i) {
    const auto type = static_cast<core::ModuleTypeId>(i);
    const language::ModuleType& moduleType = program.types[i];
    const TurtleCommand command = turtle::commandOf(program.symbols[moduleType.symbol].character(), moduleType.arity);
    commandOf.push_back(command);
    roleOf.push_back(roleFor(program, type, command));
    isSkipped.push_back(command == TurtleCommand::None && mayExpand[i] == 0 && roleOf.back() == Role::None ? 1 : 0);
    adds.push_back(addedBy(command));
    // `@mc` cuts; no other command after `@` begins with m and has an effect
    const bool mayCutAfterAt = program.symbols[moduleType.symbol].character() == 'm';
    hasCut = hasCut || command == TurtleCommand::Cut || mayCutAfterAt;
    // `$` restores the scale that an earlier `?(id,k)` changed, in whatever branch
    hasCalls = hasCalls || roleOf.back() == Role::Call || roleOf.back() == Role::SystemEnd;
  }
  hasIndependentBranches = !hasImages && !hasCalls;
  // a patch (`@PS`) takes its points from anywhere
  const auto has = [&](char character) {
    return std::ranges::any_of(program.types, [&](const language::ModuleType& type) {
      return program.symbols[type.symbol].character() == character;
    });
  };
  mayDrawApart = isRepeatable(program) && keepsBrackets(program) && !(has('@') && has('P') && has('S'));
}

}  // namespace espalier::turtle

#include "engine/turtle/interpretation/branch_parts.h"

namespace espalier::turtle {
namespace {

/// A module's part in the search.
struct ModuleStep {
  std::uint32_t opens = 0;
  std::uint32_t closes = 0;
  std::uint64_t parameters = 0;
};

std::vector<ModuleStep> stepsOf(const InterpretationTables& tables, std::span<const std::uint16_t> arity) {
  using Role = InterpretationTables::Role;
  std::vector<ModuleStep> steps(arity.size());
  for (std::size_t type = 0; type < steps.size(); ++type) {
    steps[type] = {.opens = tables.roleOf[type] == Role::OpenBranch ? 1U : 0U,
                   .closes = tables.roleOf[type] == Role::CloseBranch ? 1U : 0U,
                   .parameters = arity[type]};
  }
  return steps;
}

}  // namespace

std::vector<BranchPart> findBranchParts(const InterpretationTables& tables, std::span<const std::uint16_t> arity,
                                        std::span<const core::ModuleTypeId> types, std::uint64_t smallest,
                                        std::uint64_t largest) {
  struct Place {
    std::uint64_t module;
    std::uint64_t offset;
  };
  const std::vector<ModuleStep> steps = stepsOf(tables, arity);
  std::vector<BranchPart> parts;
  // Brackets come in no order that a processor could foresee, so that every module takes the same way: it is put on
  // top of the open branches, and stays there if it opens one.
  std::vector<Place> open(64);
  std::size_t depth = 0;
  std::uint64_t offset = 0;
  for (std::uint64_t i = 0; i < types.size(); ++i) {
    const ModuleStep& step = steps[types[i]];
    open[depth].module = i + 1;
    open[depth].offset = offset;
    depth -= depth > 0 ? step.closes : 0;
    const Place& start = open[depth];
    // of a module that closes nothing this is the largest number
    const std::uint64_t size = i - start.module;
    if (size >= smallest && size <= largest) {
      // branches inside it were found before it
      while (!parts.empty() && parts.back().firstModule > start.module) {
        parts.pop_back();
      }
      parts.push_back({start.module, i, start.offset, offset});
    }
    depth += step.opens;
    if (depth == open.size()) {
      open.resize(2 * depth);
    }
    offset += step.parameters;
  }
  return parts;
}

}  // namespace espalier::turtle

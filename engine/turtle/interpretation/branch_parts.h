#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/turtle/interpretation/interpretation_tables.h"

namespace espalier::turtle {

/// A branch of a string that is interpreted apart from the modules around it.
struct BranchPart {
  std::uint64_t firstModule = 0;  // behind its `[`
  std::uint64_t endModule = 0;    // its `]`
  std::uint64_t firstOffset = 0;  // of the parameters of firstModule
  std::uint64_t endOffset = 0;
};

/// Disjoint branches of at least `smallest` and at most `largest` modules, in the order of the string. Of nested
/// branches the outermost that is not too large is taken, so that few modules are left around them.
/// O(modules).
[[nodiscard]] std::vector<BranchPart> findBranchParts(const InterpretationTables& tables,
                                                      std::span<const std::uint16_t> arity,
                                                      std::span<const core::ModuleTypeId> types, std::uint64_t smallest,
                                                      std::uint64_t largest);

}  // namespace espalier::turtle

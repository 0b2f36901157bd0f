#pragma once

#include <cstdint>
#include <span>

#include "engine/core/identifiers.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// A part of a string.
struct StringPart {
  std::uint64_t firstModule = 0;
  std::uint64_t endModule = 0;
  std::uint64_t firstParameter = 0;
  std::uint64_t endParameter = 0;
};

/// The part that a cut symbol at `module` removes: from behind the symbol to the `]` of its branch, or to the end of
/// the string. The symbol's parameters begin at `offset`. O(modules of the part).
[[nodiscard]] StringPart findCutPart(const language::Program& program, std::span<const core::ModuleTypeId> types,
                                     std::uint64_t module, std::uint64_t offset);

}  // namespace espalier::derivation

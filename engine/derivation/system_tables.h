#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/derivation/batch/batch_plan.h"
#include "engine/derivation/matching/context_matcher.h"
#include "engine/derivation/matching/production_plan.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The facts about one L-system of a Program that the derivation computes once. Const after construction.
struct SystemTables {
  SystemTables(const language::Program& program, std::uint32_t systemIndex);

  const language::LSystem* system;  // in the Program
  ContextRules rules;
  ProductionPlan plan;
  std::optional<BatchPlan> decomposition;  // nothing: the ModuleRewriter decomposes
  BatchPlan batches;
  bool hasDecomposition = false;         // there are decomposition productions and the maximum depth is not 0
  std::vector<std::uint8_t> decomposes;  // by production: a module of its successor is a decomposition predecessor
  std::vector<std::uint8_t> isInside;    // by module type: a predecessor has it behind its first module
  bool hasContexts = false;              // a production or decomposition looks at neighbours in the old string
  bool isOrderFree = false;              // no module depends on the rewriting of another: no blocks, no `<<`, no `>>`
  bool drawsRandom = false;              // a production or decomposition draws numbers besides the choice
  bool isProducedBackwards = false;      // a production has a `>>` context: the scan runs from right to left
};

/// Whether a production of the list looks at neighbours in the string that is read.
[[nodiscard]] bool looksAround(const language::ProductionList& list);

/// The tables of all L-systems, in the order of Program::systems.
[[nodiscard]] std::vector<SystemTables> makeSystemTables(const language::Program& program);

/// An instance of an L-system's variables: all 0, arrays with their initial elements, not started.
[[nodiscard]] InstanceState makeInstance(const language::Program& program, std::uint32_t systemIndex);

/// Whether a module is a call of a sub-L-system: `?` with a parameter list.
[[nodiscard]] bool isCall(const language::Program& program, core::ModuleTypeId type);

}  // namespace espalier::derivation

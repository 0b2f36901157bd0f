#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "engine/core/simulation_error.h"
#include "engine/derivation/derivation.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Explains in words, for a person who debugs a model, what the next step of `state` does with module `module`
/// (0-based) of its string: which production fired and what it made; which candidates failed and why (what the contexts
/// saw, the value of the condition with those of its names); weights, draw and choice; the decomposition; cuts. The
/// step is really made, on a copy, by the matcher and evaluator of Derivation; it prints nothing. The same arguments
/// always give the same text.
///
/// An error when the string has no such module or the step fails before it. When it fails at the module or behind it,
/// the text ends with the failure.
[[nodiscard]] std::variant<std::string, core::SimulationError> explain(const language::Program& program,
                                                                       DerivationOptions options,
                                                                       const PlantState& state, std::uint64_t module);

}  // namespace espalier::derivation

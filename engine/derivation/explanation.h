#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>

#include "engine/core/simulation_error.h"
#include "engine/derivation/derivation.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Explains what the next step of `state` does with module `module` (0-based) of its string, in words for a person who
/// debugs a model. The text has the production that fired and its result, the candidates that failed and the reasons
/// (modules that contexts saw, values of conditions and their names), weights, draw and choice, decomposition and cuts.
/// Derivation makes the step on a copy of the state; it prints nothing. Equal arguments give equal texts.
///
/// Returns an error when the string has no such module or the step fails before it. When the step fails at the module
/// or behind it, the text ends with the failure.
[[nodiscard]] tl::expected<std::string, core::SimulationError> explain(const language::Program& program,
                                                                       DerivationOptions options,
                                                                       const PlantState& state, std::uint64_t module);

}  // namespace espalier::derivation

#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/language/program.h"

namespace espalier::language {

/// The declared communication modules that the simulation itself answers: `?Seed(asks)` or `?Seed(asks, model)` asks
/// for a new plant, `?Death` or `?Death(asks)` ends the plant it is in. Their queries do not reach the environment.
inline constexpr std::string_view kSeedName = "Seed";
inline constexpr std::string_view kDeathName = "Death";

/// A communication module that a model makes: `E` of ?E(...), or the name of a declared ?Name(...).
struct ModelQuery {
  std::string name;
  core::SourceRange range;  // where an axiom or successor makes it first
};

/// The communication modules that the axioms and successors of a model make, each name once, in the order of the text.
[[nodiscard]] std::vector<ModelQuery> queriesOf(const Program& program);

/// A warning for every query of a model that no process answers. `processNames` are the processes of the environment;
/// letter case does not matter. Every process answers ?E(...). An empty list: there is no environment.
[[nodiscard]] std::vector<core::Diagnostic> unansweredQueries(const Program& program,
                                                              const std::vector<std::string>& processNames);

/// A warning that no module of the model asks the environment that it is given. Nothing: one does.
[[nodiscard]] std::optional<core::Diagnostic> unaskedEnvironment(const Program& program);

/// A warning for every fopen that writes, for callers that do not let models write files.
[[nodiscard]] std::vector<core::Diagnostic> unwrittenFiles(const Program& program);

}  // namespace espalier::language

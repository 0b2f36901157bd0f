#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/result.h"
#include "engine/core/identifiers.h"
#include "engine/language/program.h"

namespace espalier::command {

/// Modules as a plan names them: `*`, `A` (with any number of parameters) or `A(l,w)`, which names the parameters.
struct ModulePattern {
  std::string symbol;          // empty: every module
  bool hasParameters = false;  // `parameters` count
  std::vector<std::string> parameters{};

  /// The place of the problem is for the caller to add.
  [[nodiscard]] static Result<ModulePattern> read(std::string_view text);

  /// By module type: whether the pattern means it.
  [[nodiscard]] std::vector<bool> typesOf(const language::Program& program) const;
  /// The sentence about a pattern that means no module of the program, with what the program has; empty: it means one.
  [[nodiscard]] std::string problemIn(const language::Program& program) const;
  /// The pattern as it was written.
  [[nodiscard]] std::string text() const;
};

}  // namespace espalier::command

#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/limits.h"
#include "engine/language/compiler.h"
#include "engine/language/program.h"

namespace espalier::language {

/// The names of which a source of the model has a `#define`; views into the sources. O(text).
[[nodiscard]] std::vector<std::string_view> definedNames(const Program& program);

/// Whether a source of the model has a `#define` of the name. O(text).
[[nodiscard]] bool definesName(const Program& program, std::string_view name);

/// The model compiled again with other values of the names that it defines; pairs of other names are left out.
/// simulation::withPrograms puts the result into a run.
[[nodiscard]] CompileResult withDefinitions(const Program& program,
                                            const std::vector<std::pair<std::string, std::string>>& definitions,
                                            const core::Limits& limits);

}  // namespace espalier::language

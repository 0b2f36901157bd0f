#pragma once

#include <string>

#include "engine/language/program.h"

namespace espalier::derivation {

/// Says for each production of a model in which way a step applies it to long strings, and why, in lines of text
/// (DESIGN.md, Which scan). All productions of one module type go the same way.
[[nodiscard]] std::string planText(const language::Program& program);

}  // namespace espalier::derivation

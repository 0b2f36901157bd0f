#pragma once

#include <memory>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/language/program.h"

namespace espalier::language {

struct CompileResult {
  std::shared_ptr<const Program> program;  // null when there are errors
  core::DiagnosticList diagnostics;        // errors and warnings, in the order of the text
};

/// Reads, preprocesses, parses, analyses and compiles a model. Never throws for bad input: the diagnostics hold
/// every mistake that can be found.
[[nodiscard]] CompileResult compile(const CompileInput& input, core::FileProvider& files);

}  // namespace espalier::language

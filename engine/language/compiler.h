#pragma once

#include <functional>
#include <memory>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/language/program.h"

namespace espalier::language {

struct ParsedModel;

struct CompileResult {
  std::shared_ptr<const Program> program;  // null when there are errors
  core::DiagnosticList diagnostics;        // errors and warnings, in the order of the text
};

/// Reads, preprocesses, parses, analyses and compiles a model. Never throws for bad input: the diagnostics hold
/// every mistake that can be found. `onParsed` sees the model before it is compiled, also one with mistakes; not a
/// model in another program's notation.
[[nodiscard]] CompileResult compile(const CompileInput& input, core::FileProvider& files,
                                    const std::function<void(const ParsedModel&)>& onParsed = {});

}  // namespace espalier::language

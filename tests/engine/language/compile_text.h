#pragma once

#include <string>
#include <utility>
#include <vector>

#include "engine/core/streams.h"
#include "engine/language/compiler.h"

namespace espalier::language {

/// Compiles a model held in memory as `m.l`.
inline CompileResult compileText(const std::string& text, core::Compatibility mode = core::Compatibility::Espalier,
                                 core::Limits limits = {},
                                 std::vector<std::pair<std::string, std::string>> defines = {}) {
  core::MemoryFileProvider files({{"m.l", text}});
  CompileInput input;
  input.modelFile = "m.l";
  input.compatibility = mode;
  input.limits = limits;
  input.defines = std::move(defines);
  return compile(input, files);
}

/// "line:column: error: message | hint", the hint only when there is one.
inline std::string brief(const core::Diagnostic& diagnostic) {
  std::string text = std::to_string(diagnostic.location.line) + ":" + std::to_string(diagnostic.location.column) +
                     ": " + (diagnostic.severity == core::Severity::Error ? "error: " : "warning: ") +
                     diagnostic.message;
  return diagnostic.hint.empty() ? text : text + " | " + diagnostic.hint;
}

inline std::vector<std::string> briefs(const core::DiagnosticList& diagnostics) {
  std::vector<std::string> result;
  for (const core::Diagnostic& diagnostic : diagnostics.entries()) {
    result.push_back(brief(diagnostic));
  }
  return result;
}

inline std::vector<std::string> messagesOf(const std::string& text,
                                           core::Compatibility mode = core::Compatibility::Espalier,
                                           core::Limits limits = {}) {
  return briefs(compileText(text, mode, limits).diagnostics);
}

/// A model around productions: line 3 is the first production.
inline std::string model(const std::string& productions, const std::string& axiom = "A(1)") {
  return "Lsystem: 1\nAxiom: " + axiom + "\n" + productions + "\nendlsystem\n";
}

using Messages = std::vector<std::string>;

}  // namespace espalier::language

#pragma once

#include <string>
#include <vector>

#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/language/dialects/dialect.h"
#include "tests/engine/language/compile_text.h"

namespace espalier::language {

/// Compiles a foreign model held in memory as `m.txt`, or one of its entries.
inline CompileResult compileForeign(const std::string& text, const std::string& entry = {},
                                    const std::string& dialect = {}) {
  core::MemoryFileProvider files({{"m.txt", text}});
  CompileInput input;
  input.modelFile = entry.empty() ? "m.txt" : "m.txt:" + entry;
  input.dialect = dialect;
  return compile(input, files);
}

/// The messages about a foreign model, in the form of `brief`.
inline std::vector<std::string> foreignMessages(const std::string& text, const std::string& entry = {},
                                                const std::string& dialect = {}) {
  return briefs(compileForeign(text, entry, dialect).diagnostics);
}

/// The cpfg text of a foreign model; empty when it has errors.
inline std::string cpfgText(const std::string& text, const std::string& entry = {}, const std::string& dialect = {}) {
  const CompileResult result = compileForeign(text, entry, dialect);
  return result.program == nullptr ? std::string{} : result.program->sources.front().text;
}

/// The cpfg text of a foreign model as a file for other programs.
inline std::string aloneText(const std::string& text) {
  core::MemoryFileProvider files({{"m.txt", text}});
  CompileInput input;
  input.modelFile = "m.txt";
  const auto translated = translateForeign(input, files);
  return translated ? modelText(translated->model, true).text() : std::string{};
}

/// The dialect that recognises a text; empty: cpfg.
inline std::string recognised(const std::string& text) {
  core::MemoryFileProvider files({{"m.txt", text}});
  CompileInput input;
  input.modelFile = "m.txt";
  const auto translated = translateForeign(input, files);
  return translated ? std::string(translated->dialect->name) : std::string{};
}

}  // namespace espalier::language

#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/limits.h"
#include "engine/core/streams.h"
#include "engine/files/source_map.h"

namespace espalier::language {

struct PreprocessInput {
  std::string file;
  std::vector<std::pair<std::string, std::string>> macros;  // defined before the first line; #define can replace them
  std::vector<std::pair<std::string, std::string>> overrides;  // the caller's: they win over #define
  core::Limits limits;
};

struct PreprocessResult {
  std::string text;
  files::SourceMap sourceMap;
  core::DiagnosticList diagnostics;
  std::vector<std::uint32_t> commentNewlines;  // offsets in `text` of the newlines inside comments, ascending
  std::vector<std::string> macros;             // names of the macros defined at the end
  bool hasLostText = false;                    // an open comment contains the rest of a file
  bool isComplete = true;                      // false: the file could not be read, or a limit was reached
};

/// A traditional C preprocessor: #define (also with arguments), #undef, #include, #if and its relatives, both comment
/// forms, line continuation. Used for `.l` and `.v` files and background scenes. An included file is looked for
/// beside the file that includes it.
[[nodiscard]] PreprocessResult preprocess(const PreprocessInput& input, core::FileProvider& files);

}  // namespace espalier::language

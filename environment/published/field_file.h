#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "environment/published/text_exchange.h"

namespace espalier::environment {

/// What an `.e` file says.
struct FieldFile {
  std::string program;                 // without its folder and suffix
  std::vector<std::string> command;    // the program as written, then its arguments
  std::string specification;           // file name, beside the `.e` file; empty: none
  core::SourceLocation executable;     // of the program's name
  TurtleFormats formats;               // what is sent, and how it arrives
  std::array<std::string, 6> printed;  // the formats as written: position, heading, left, up, width, scale; empty: none
  std::size_t chunkModules = 100;      // modules in one chunk of the pipe coupling
};

/// Reads an `.e` file. Errors and warnings, each with its line, are appended; after an error the result is incomplete.
/// That no program is named is for the caller to judge.
[[nodiscard]] FieldFile readFieldFile(const std::string& file, std::string_view text,
                                      std::vector<core::Diagnostic>& warnings, std::vector<core::Diagnostic>& errors);

/// The error for a field file without `executable`.
[[nodiscard]] core::Diagnostic missingProgram(const std::string& file);

}  // namespace espalier::environment

#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "environment/published/text_coupling.h"

namespace espalier::environment {

/// The content of an `.e` file.
struct EnvironmentFile {
  std::string program;               // without its folder and suffix
  std::vector<std::string> command;  // the program as written, then its arguments
  std::string specification;         // file name, beside the `.e` file; empty: none
  core::SourceLocation executable;   // of the program's name
  TurtleFormats formats;             // of the turtle items that are sent
  // the formats as written, with the blanks before them: position, heading, left, up, width, scale; empty: none
  std::array<std::string, 6> printed;
  std::size_t chunkModules = 100;  // modules in one chunk of the pipe coupling
  // the arguments that a built-in process ignores, and a program that is started receives
  std::vector<core::Diagnostic> ignoredArguments;
};

/// Reads an `.e` file. Errors and warnings, each with its line, are appended; after an error the result is incomplete.
/// The caller decides whether a file without a program is an error.
[[nodiscard]] EnvironmentFile readEnvironmentFile(const std::string& file, std::string_view text,
                                                  std::vector<core::Diagnostic>& warnings,
                                                  std::vector<core::Diagnostic>& errors);

/// The text of an `.e` file for a program that talks over pipes: every line `communication type` says so and keeps the
/// number behind the type. Nothing when the text says nothing else.
[[nodiscard]] std::optional<std::string> textForPipes(std::string_view text);

/// The error for an environment file without `executable`.
[[nodiscard]] core::Diagnostic missingProgram(const std::string& file);

}  // namespace espalier::environment

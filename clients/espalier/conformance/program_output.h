#pragma once

#include <chrono>
#include <string>
#include <tl/expected.hpp>

namespace espalier::conformance {

/// The output of a program that ended by itself.
struct ProgramOutput {
  std::string output;  // standard output
  std::string errors;  // standard error
  int status = 0;      // exit status; 128 + N after signal N
};

/// The bounds of a run.
struct ProgramLimits {
  std::chrono::milliseconds time{10'000};
  std::size_t outputBytes = 64'000'000;  // of standard output, and of standard error
};

/// Runs a command of the shell in a folder, with empty standard input and a process group of its own. A run that takes
/// longer or prints more than the limits is ended with its children; the error is a sentence that begins with a verb:
/// "does not end within 10 s".
[[nodiscard]] tl::expected<ProgramOutput, std::string> runProgram(const std::string& command, const std::string& folder,
                                                                  const ProgramLimits& limits);

/// A text as one word of the shell.
[[nodiscard]] std::string quoted(const std::string& text);

}  // namespace espalier::conformance

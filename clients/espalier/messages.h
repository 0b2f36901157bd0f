#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/simulation_error.h"
#include "engine/core/streams.h"

namespace espalier::command {

/// Exit statuses of the program.
inline constexpr int kSuccess = 0;
inline constexpr int kFailure = 1;  // the command failed: bad model, environment gone, unwritable output
inline constexpr int kUsage = 2;    // wrong command line

/// Writes "error: " and the sentence as one line on standard error.
void printError(std::string_view sentence);

/// Writes a line on standard error.
void printNote(std::string_view line);

/// Writes diagnostics on standard error in the order given. With `isQuiet` only the errors.
void printDiagnostics(const std::vector<core::Diagnostic>& diagnostics, bool isQuiet);

/// The same; with `isStrict` a warning is an error. False: there was a warning, and `isStrict` forbids it.
[[nodiscard]] bool printDiagnostics(std::vector<core::Diagnostic> diagnostics, bool isQuiet, bool isStrict);

/// The line for a model that failed while running: the step, the failure, and the step at which the simulation stays.
[[nodiscard]] std::string formatSimulationError(const core::SimulationError& error);

/// A model's printf output and run-time warnings on standard error. With `isQuiet` the printf output only.
[[nodiscard]] core::MessageSink standardErrorMessages(bool isQuiet);

}  // namespace espalier::command

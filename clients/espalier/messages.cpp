#include "clients/espalier/messages.h"

#include <cstdio>
#include <string>

namespace espalier::command {
namespace {

void writeToStandardError(std::string_view text) {
  // results that are still buffered come first, so that a terminal shows both in the order they were made
  std::fflush(stdout);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace

void printError(std::string_view sentence) { writeToStandardError("error: " + std::string(sentence) + "\n"); }

void printNote(std::string_view line) { writeToStandardError(std::string(line) + "\n"); }

void printDiagnostics(const std::vector<core::Diagnostic>& diagnostics, bool isQuiet) {
  for (const core::Diagnostic& diagnostic : diagnostics) {
    if (isQuiet && diagnostic.severity != core::Severity::Error) {
      continue;
    }
    writeToStandardError(core::formatDiagnostic(diagnostic) + "\n");
  }
}

std::string formatSimulationError(const core::SimulationError& error) {
  if (error.code == core::SimulationErrorCode::Snapshot) {
    return error.message;
  }
  std::string text = "step " + std::to_string(error.step) + ", plant " + std::to_string(error.plant);
  if (error.module) {
    text += ", module " + std::to_string(*error.module);
  }
  if (!error.location.file.empty()) {
    text += " (" + error.location.file + ":" + std::to_string(error.location.line) + ":" +
            std::to_string(error.location.column) + ")";
  }
  return text + ": " + error.message;
}

core::MessageSink standardErrorMessages(bool isQuiet) {
  return [isQuiet](core::MessageKind kind, std::string_view text) {
    if (kind == core::MessageKind::Printf) {
      writeToStandardError(text);
    } else if (!isQuiet) {
      writeToStandardError("warning: " + std::string(text) + "\n");
    }
  };
}

}  // namespace espalier::command

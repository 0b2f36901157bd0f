#include "clients/espalier/messages.h"

#include <cstdio>
#include <string>

#include "engine/core/message_text.h"
#include "server/remote/limits.h"

namespace espalier::command {
namespace {

void writeToStandardError(std::string_view text) {
  // write buffered results first, so that a terminal shows both in their order
  std::fflush(stdout);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace

void printError(std::string_view sentence) {
  writeToStandardError(core::messageText("error: " + std::string(sentence)) + "\n");
}

void printNote(std::string_view line) {
  writeToStandardError(std::string(line) + "\n");
}

void printDiagnostics(const std::vector<core::Diagnostic>& diagnostics, bool isQuiet) {
  for (const core::Diagnostic& diagnostic : diagnostics) {
    if (isQuiet && diagnostic.severity != core::Severity::Error) {
      continue;
    }
    writeToStandardError(core::formatDiagnostic(diagnostic) + "\n");
  }
}

bool printDiagnostics(std::vector<core::Diagnostic> diagnostics, bool isQuiet, bool isStrict) {
  bool isAllowed = true;
  for (core::Diagnostic& diagnostic : diagnostics) {
    if (isStrict && diagnostic.severity == core::Severity::Warning) {
      diagnostic.severity = core::Severity::Error;
      isAllowed = false;
    }
  }
  printDiagnostics(diagnostics, isQuiet);
  if (!isAllowed) {
    printError("a warning is an error here: mend the file, or leave out --strict");
  }
  return isAllowed;
}

std::string formatSimulationError(const core::SimulationError& error) {
  // messages of the engine name their step, messages of an environment do not
  const bool needsStep = error.code == core::SimulationErrorCode::EnvironmentFailed && error.step > 0;
  std::string text = (needsStep ? "step " + std::to_string(error.step) + ": " : std::string{}) + error.message;
  // add how to set the limit
  if (error.code == core::SimulationErrorCode::LimitExceeded) {
    if (const server::LimitEntry* limit = server::limitNamedIn(text)) {
      text += " (--limit " + std::string(limit->name) + "=N sets another bound.)";
    }
  }
  return text;
}

core::MessageSink standardErrorMessages(bool isQuiet) {
  return [isQuiet](core::MessageKind kind, std::string_view text) {
    if (kind == core::MessageKind::Printf) {
      writeToStandardError(text);
    } else if (!isQuiet) {
      // a warning with a place has the word in its first line
      const bool isMarked = text.substr(0, text.find('\n')).find("warning: ") != std::string_view::npos;
      writeToStandardError((isMarked ? "" : "warning: ") + std::string(text) + "\n");
    }
  };
}

}  // namespace espalier::command

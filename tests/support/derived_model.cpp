#include "tests/support/derived_model.h"

#include <stdexcept>
#include <utility>

#include "engine/core/diagnostic.h"
#include "engine/derivation/state/string_text.h"
#include "engine/language/compiler.h"

namespace espalier::test {

DerivedModel::DerivedModel(const std::string& text, derivation::DerivationOptions options,
                           core::Compatibility compatibility, const std::string& view)
    : log_(std::make_shared<Log>()) {
  core::MemoryFileProvider files;
  files.add("model.l", text);
  language::CompileInput input;
  input.modelFile = "model.l";
  input.compatibility = compatibility;
  if (!view.empty()) {
    files.add("model.v", view);
    input.viewFile = "model.v";
  }
  const language::CompileResult result = language::compile(input, files);
  if (!result.program) {
    std::string message;
    for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
      message += core::formatDiagnostic(diagnostic) + "\n";
    }
    throw std::runtime_error(message);
  }
  program_ = result.program;
  options.messages = [log = log_](core::MessageKind kind, std::string_view message) {
    if (kind == core::MessageKind::Printf) {
      log->printed.append(message);
    } else {
      log->warnings.emplace_back(message);
    }
  };
  derivation_ = std::make_unique<derivation::Derivation>(*program_, std::move(options));
  derivation_->rewind(state_);
}

std::string DerivedModel::steps(std::uint64_t count) {
  for (std::uint64_t i = 0; i < count; ++i) {
    derivation_->derive(state_);
  }
  return text();
}

core::SimulationError DerivedModel::failingStep() {
  try {
    derivation_->derive(state_);
  } catch (const core::SimulationFailure& failure) {
    return failure.error();
  }
  throw std::runtime_error("the step did not fail");
}

std::string DerivedModel::text() const {
  return derivation::toText(*program_, state_.string, derivation::numberStyle(program_->compatibility));
}

std::string derive(const std::string& text, std::uint64_t stepCount, core::Compatibility compatibility) {
  return DerivedModel(text, {}, compatibility).steps(stepCount);
}

std::string modelText(const std::string& items, const std::string& axiom, const std::string& rest) {
  return "Lsystem: 1\nderivation length: 100\n" + items + "Axiom: " + axiom + "\n" + rest + "endlsystem\n";
}

}  // namespace espalier::test

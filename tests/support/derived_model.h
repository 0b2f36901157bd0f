#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/simulation_error.h"
#include "engine/derivation/derivation.h"
#include "engine/language/program.h"

namespace espalier::test {

/// A model given as text, compiled and rewound, with everything it prints. Throws std::runtime_error with the
/// diagnostics when the text has errors. The file is called "model.l".
class DerivedModel {
 public:
  explicit DerivedModel(const std::string& text, derivation::DerivationOptions options = {},
                        core::Compatibility compatibility = core::Compatibility::Espalier,
                        const std::string& view = {});

  /// Makes steps and returns the string.
  std::string steps(std::uint64_t count);
  /// One step more; the error it fails with.
  core::SimulationError failingStep();
  [[nodiscard]] std::string text() const;

  [[nodiscard]] const language::Program& program() const { return *program_; }
  [[nodiscard]] derivation::Derivation& derivation() { return *derivation_; }
  [[nodiscard]] derivation::PlantState& state() { return state_; }
  [[nodiscard]] const std::string& printed() const { return log_->printed; }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return log_->warnings; }

 private:
  struct Log {
    std::string printed;
    std::vector<std::string> warnings;
  };
  std::shared_ptr<const language::Program> program_;
  std::shared_ptr<Log> log_;
  std::unique_ptr<derivation::Derivation> derivation_;
  derivation::PlantState state_;
};

/// The string of a model after some steps.
[[nodiscard]] std::string derive(const std::string& text, std::uint64_t stepCount,
                                 core::Compatibility compatibility = core::Compatibility::Espalier);

/// "Lsystem: 1 / derivation length: 100 / ITEMS / Axiom: AXIOM / REST / endlsystem", one line each; `items` and `rest`
/// end with newlines or are empty.
[[nodiscard]] std::string modelText(const std::string& items, const std::string& axiom, const std::string& rest);

}  // namespace espalier::test

#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"

namespace espalier::simulation {

/// The Program of a model given as text, with an optional view file.
inline std::shared_ptr<const language::Program> compileText(
    const std::string& model, const std::string& view = {},
    core::Compatibility compatibility = core::Compatibility::Espalier) {
  core::MemoryFileProvider files;
  files.add("model.l", model);
  language::CompileInput input;
  input.modelFile = "model.l";
  if (!view.empty()) {
    files.add("model.v", view);
    input.viewFile = "model.v";
  }
  input.compatibility = compatibility;
  language::CompileResult result = language::compile(input, files);
  for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
    if (diagnostic.severity == core::Severity::Error) {
      ADD_FAILURE() << core::formatDiagnostic(diagnostic);
    }
  }
  return result.program;
}

/// The log that the test reads after the simulation owns the environment.
struct FakeEnvironmentLog {
  int openCount = 0;
  int stepCount = 0;
  std::vector<std::uint64_t> ticks;
  std::vector<turtle::QueryBatch> batches;
  turtle::EnvironmentContext context;
  std::optional<turtle::EnvironmentError> nextError;  // returned once by the next step
  std::string note;                                   // of every step; empty: none
  double answer = 0.0;                                // added to the state for every query
};

/// Answers query q of its step n with 100 n + q + `answer` in the first parameter; the number of steps is its state.
class FakeEnvironment final : public turtle::EnvironmentProcess {
 public:
  explicit FakeEnvironment(std::shared_ptr<FakeEnvironmentLog> log, std::string name = "fake")
      : log_(std::move(log)), name_(std::move(name)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = name_;
    description.needs.position = true;
    description.needs.parameters = true;
    description.isStateful = true;
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    ++log_->openCount;
    log_->context = context;
    state_ = 0;
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (log_->nextError) {
      return std::exchange(log_->nextError, std::nullopt);
    }
    ++log_->stepCount;
    if (!log_->note.empty()) {
      replies.notes.push_back(log_->note);
    }
    log_->batches.push_back(queries);
    for (std::size_t query = 0; query < queries.size(); ++query) {
      replies.set(queries, query, 0, 100.0 * state_ + static_cast<double>(query) + log_->answer);
    }
    ++state_;
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) override {
    log_->ticks.push_back(step);
    return std::nullopt;
  }
  [[nodiscard]] std::string save() const override { return std::to_string(state_); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    if (state.empty() || state[0] < '0' || state[0] > '9') {
      return turtle::EnvironmentError{"the state is not a number", false};
    }
    state_ = std::stoi(std::string(state));
    return std::nullopt;
  }

 private:
  std::shared_ptr<FakeEnvironmentLog> log_;
  std::string name_;
  int state_ = 0;
};

/// A simulation and what its environment saw.
struct TestRun {
  explicit TestRun(std::shared_ptr<const language::Program> program, std::size_t plants = 1,
                   SimulationOptions options = {}, bool hasEnvironment = true)
      : simulation(std::move(program), placements(plants),
                   hasEnvironment ? std::make_unique<FakeEnvironment>(log) : nullptr, std::move(options)) {}

  static std::vector<turtle::PlantPlacement> placements(std::size_t count) {
    std::vector<turtle::PlantPlacement> result(count);
    for (std::size_t i = 0; i < count; ++i) {
      result[i].position = {4.0 * static_cast<double>(i), 0.0, 0.0};
    }
    return result;
  }

  std::shared_ptr<FakeEnvironmentLog> log = std::make_shared<FakeEnvironmentLog>();
  Simulation simulation;
};

inline void expectSuccess(const std::optional<core::SimulationError>& error) {
  EXPECT_FALSE(error.has_value()) << (error ? error->message : "");
}

// an apex that draws its reply and asks again; the reply is kept in the string, and random numbers are used
inline const char* const kAskingModel =
    "Lsystem: 1\n"
    "seed: 5\n"
    "derivation length: 8\n"
    "Start: {c=0;}\n"
    "StartEach: {c=c+1;}\n"
    "Axiom: F(1)A(0)?E(0)\n"
    "A(n) > ?E(x) --> F(1+ran(1))B(x,c)A(n+1) : 0.5\n"
    "A(n) > ?E(x) --> [+F(2)?E(n)]C(x)A(n+2) : 0.5\n"
    "homomorphism\n"
    "C(x) : {c=c+100;} * --> F(0.5)\n"
    "endlsystem\n";

}  // namespace espalier::simulation

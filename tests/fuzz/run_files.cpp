#include "tests/fuzz/run_files.h"

#include <utility>
#include <vector>

#include "engine/core/check.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/trace.h"
#include "tests/fuzz/bundle.h"
#include "tests/fuzz/small_limits.h"

namespace espalier::fuzz {
namespace {

constexpr int kRunSteps = 4;

class AnsweringEnvironment final : public turtle::EnvironmentProcess {
 public:
  explicit AnsweringEnvironment(std::string name) { description_.name = std::move(name); }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return description_; }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    for (std::size_t query = 0; query < queries.size(); ++query) {
      replies.set(queries, query, 0, static_cast<double>(query % 3));
    }
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t) override { return std::nullopt; }
  [[nodiscard]] std::string save() const override { return state_; }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    state_ = state;
    return std::nullopt;
  }

 private:
  turtle::EnvironmentDescription description_;
  std::string state_ = "state";
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makeAnsweringEnvironment(std::string name) {
  return std::make_unique<AnsweringEnvironment>(std::move(name));
}

std::optional<RunFiles> runFilesOf(std::string_view bundle, core::Compatibility compatibility) {
  core::MemoryFileProvider files = unbundle(bundle, kModel);
  language::CompileInput input;
  input.modelFile = kModel;
  input.viewFile = files.read(kView) ? kView : "";
  input.compatibility = compatibility;
  input.limits = smallLimits();
  const language::CompileResult compiled = language::compile(input, files);
  if (compiled.program == nullptr) {
    return std::nullopt;
  }
  simulation::SimulationOptions options;
  options.limits = smallLimits();
  options.seed = 1;
  options.hasSeed = true;
  core::StringSink trace;
  auto recorder = std::make_shared<simulation::TraceRecorder>(trace);
  simulation::Simulation simulation(
      compiled.program, std::vector<turtle::PlantPlacement>(1),
      simulation::record(compiled.program->hasQueries ? makeAnsweringEnvironment("answers") : nullptr, recorder),
      options);
  if (simulation.rewind()) {
    return std::nullopt;
  }
  recorder->begin(simulation);
  for (int step = 0; step < kRunSteps && !simulation.isFinished() && !simulation.step(); ++step) {
    recorder->complete(simulation);
  }
  core::StringSink snapshot;
  simulation.save(snapshot);
  // no check refuses a snapshot that a run has made
  const auto refused = simulation.restore(snapshot.text());
  ESPALIER_CHECK(!refused);
  return RunFiles{snapshot.take(), trace.take(), simulation.stringText()};
}

}  // namespace espalier::fuzz

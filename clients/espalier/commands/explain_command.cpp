#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/number_option.h"
#include "engine/derivation/explanation.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

struct ExplainOptions {
  ModelOptions model;
  std::uint64_t step = 1;
  std::uint64_t module = 0;
  std::uint32_t plant = 0;
};

/// An explanation runs the model and leaves no trace of it.
class DiscardingWriter final : public core::FileWriter {
 public:
  std::optional<std::string> write(const std::string& /*name*/, bool /*replaces*/,
                                   std::string_view /*bytes*/) override {
    return std::nullopt;
  }
};

int explain(ExplainOptions& options) {
  server::DiskFileProvider files;
  std::optional<LoadedModel> loaded = loadModel(options.model, files);
  if (!loaded) {
    return kFailure;
  }
  loaded->simulationOptions.fileWriter = std::make_shared<DiscardingWriter>();
  // of one model as many plants are grown as it takes; a forest has those it has
  if (!loaded->isForest) {
    loaded->plants.resize(options.plant + std::size_t{1});
  }
  simulation::Simulation simulation(loaded->programs, loaded->plants, std::move(loaded->environment.process),
                                    std::move(loaded->simulationOptions));
  // to the string that the step reads, with the environment's answers in it
  std::optional<core::SimulationError> failure = simulation.rewind();
  while (!failure && simulation.completedSteps() + 1 < options.step) {
    if (simulation.isFinished()) {
      printError("step " + std::to_string(options.step) + " is never made: the model ends with step " +
                 std::to_string(simulation.completedSteps()) + " (--steps derives further)");
      return kFailure;
    }
    failure = simulation.step();
  }
  if (!failure && simulation.isFinished()) {
    printError("step " + std::to_string(options.step) + " is never made: the model ends with step " +
               std::to_string(simulation.completedSteps()) + " (--steps derives further)");
    return kFailure;
  }
  if (!failure) {
    failure = simulation.answer();
  }
  if (failure) {
    printError(formatSimulationError(*failure));
    return kFailure;
  }
  if (options.plant >= simulation.plantCount() || !simulation.plant(options.plant).isAlive()) {
    printError("there is no plant " + std::to_string(options.plant) + " at step " +
               std::to_string(simulation.completedSteps()) +
               ": `espalier derive` prints the numbers of those that live");
    return kFailure;
  }
  const auto explained =
      derivation::explain(simulation.program(options.plant), simulation.derivationOptions(options.plant),
                          simulation.plantState(options.plant), options.module);
  if (const auto* error = std::get_if<core::SimulationError>(&explained)) {
    printError(formatSimulationError(*error));
    return kFailure;
  }
  const std::string& text = std::get<std::string>(explained);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return kSuccess;
}

}  // namespace

void addExplain(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("explain", "Say why a step did with a module what it did");
  command->footer(
      "Step K rewrites the string of step K-1, which `espalier derive MODEL --every` prints; modules are counted from "
      "0, and\n"
      "`[`, `]` and `?` count. The answer names the production that fired and what it made, and for every other "
      "candidate\n"
      "why it did not apply: the modules that its contexts saw, the value of its condition. In a stochastic model it "
      "shows\n"
      "the weights and the draw; draws depend on the seed, so give --seed when the model has no `seed:`.\n"
      "Examples:\n"
      "  espalier explain tree.l --step 3 --module 12\n"
      "  espalier explain tiers.l --step 5 --module 40 --environment honda.json\n"
      "  espalier explain bush.l --step 2 --module 0 --seed 7");
  auto options = std::make_shared<ExplainOptions>();
  addReadingOptions(*command, options->model, true);
  addRunningOptions(*command, options->model);
  addWholeNumber(*command, "--step", "The step to explain, from 1", 1, kMaximumSteps,
                 [options](std::uint64_t step) { options->step = step; })
      ->type_name("K")
      ->required();
  addWholeNumber(*command, "--module", "The module of the string of step K-1, from 0", 0,
                 std::numeric_limits<std::uint64_t>::max(),
                 [options](std::uint64_t module) { options->module = module; })
      ->type_name("I")
      ->required();
  command
      ->add_option("--plant", options->plant,
                   "The plant whose random numbers are drawn, from 0; as many plants stand at the origin")
      ->type_name("P")
      ->check(CLI::Range(0, 9999))
      ->capture_default_str();
  command->callback([options, &status] { status = explain(*options); });
}

}  // namespace espalier::command

#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
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

/// Discards the files of the model: an explanation writes none.
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
  // a single model grows as many plants as --plant needs; a forest keeps its plants
  if (!loaded->isForest) {
    loaded->plants.resize(options.plant + std::size_t{1});
  }
  simulation::Simulation simulation(loaded->programs, loaded->plants, std::move(loaded->environment.process),
                                    std::move(loaded->simulationOptions));
  // derive the string that the step reads, and write the answers of the environment into it
  std::optional<core::SimulationError> failure = simulation.rewind();
  while (!failure && simulation.completedSteps() + 1 < options.step) {
    if (simulation.isFinished()) {
      printError("step " + std::to_string(options.step) + " does not exist: the model ends with step " +
                 std::to_string(simulation.completedSteps()) + " (--steps N derives more)");
      return kFailure;
    }
    failure = simulation.step();
  }
  if (!failure && simulation.isFinished()) {
    printError("step " + std::to_string(options.step) + " does not exist: the model ends with step " +
               std::to_string(simulation.completedSteps()) + " (--steps N derives more)");
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
               ": `espalier derive` prints the numbers of the living plants");
    return kFailure;
  }
  const auto explained =
      derivation::explain(simulation.program(options.plant), simulation.derivationOptions(options.plant),
                          simulation.plantState(options.plant), options.module);
  if (!explained) {
    printError(formatSimulationError(explained.error()));
    return kFailure;
  }
  const std::string& text = *explained;
  std::fwrite(text.data(), 1, text.size(), stdout);
  return kSuccess;
}

}  // namespace

void addExplain(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("explain", "Explain which production a step applied to a module");
  command->footer(
      "Step K rewrites the string of step K-1, which `espalier derive MODEL --every` prints. Modules are counted from "
      "0;\n"
      "`[`, `]` and `?` are modules too. The explanation names the production that was applied, and its successor. "
      "For\n"
      "every other candidate it says why it was not applied: its contexts, or the value of its condition. For a\n"
      "stochastic model it shows the weights and the draw. Draws depend on the seed: give --seed when the model has "
      "no\n"
      "`seed:`.\n"
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
                   "Number of the plant, from 0; P+1 plants stand at the origin and differ in their random draws")
      ->type_name("P")
      ->check(CLI::Range(0, 9999))
      ->capture_default_str();
  command->callback([options, &status] { status = explain(*options); });
}

}  // namespace espalier::command

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/output/outputs.h"
#include "clients/espalier/resumed_run.h"
#include "engine/language/compiler.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

struct ExportOptions {
  std::string snapshot;
  OutputOptions outputs;
  unsigned threads = 1;
  bool isQuiet = false;
};

/// Replaces the environment of a snapshot that is only drawn. It keeps the state and answers nothing.
class SleepingEnvironment final : public turtle::EnvironmentProcess {
 public:
  explicit SleepingEnvironment(std::string name) : name_(std::move(name)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = name_;
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch&, turtle::ReplyBatch&) override {
    return turtle::EnvironmentError{"The environment of a snapshot that is exported cannot be asked.", false};
  }
  [[nodiscard]] std::string save() const override { return state_; }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    state_ = state;
    return std::nullopt;
  }

 private:
  std::string name_;
  std::string state_;
};

int exportSnapshot(const ExportOptions& options) {
  if (const int status = checkOutputs(options.outputs); status != kSuccess) {
    return status;
  }
  server::DiskFileProvider files;
  std::optional<ResumedRun> read = readResumedRun(options.snapshot, {}, files);
  if (!read) {
    return kFailure;
  }
  simulation::SnapshotInfo& info = read->info;
  auto compiled = simulation::compileModels(info, core::Limits{});
  if (!compiled) {
    printDiagnostics(compiled.error().entries(), true);
    return kFailure;
  }
  std::unique_ptr<turtle::EnvironmentProcess> environment;
  if (!info.environmentName.empty()) {
    environment = std::make_unique<SleepingEnvironment>(info.environmentName);
  }
  simulation::SimulationOptions simulationOptions;
  simulationOptions.environmentOrigin = info.environmentOrigin;
  simulationOptions.messages = standardErrorMessages(options.isQuiet);
  simulation::Simulation simulation(std::move(*compiled), std::vector<simulation::PlantOrigin>(info.plantCount),
                                    std::move(environment), std::move(simulationOptions));
  if (const auto failure = simulation.restore(read->bytes)) {
    printError("'" + options.snapshot + "': " + formatSimulationError(*failure));
    return kFailure;
  }
  return OutputWriter(options.outputs, options.isQuiet).write(simulation) ? kSuccess : kFailure;
}

}  // namespace

void addExport(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("export", "Write pictures, meshes or tables of a snapshot");
  command->footer(
      "Draws the state of the snapshot in the colours of the snapshot. Derives nothing and asks no environment.\n"
      "Examples:\n"
      "  espalier export tree.snapshot -o tree.glb -o tree.png --size 1200x1600\n"
      "  espalier export tree.snapshot -o modules.csv -o tree.mtg");
  auto options = std::make_shared<ExportOptions>();
  command->add_option("snapshot", options->snapshot, "A snapshot file of `run -o NAME.snapshot` or `connect save`")
      ->type_name("FILE.snapshot")
      ->required();
  addOutputOptions(*command, options->outputs, true);
  command->add_option("--threads", options->threads, "Threads for drawing; the result does not depend on their number")
      ->type_name("N")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_flag("--quiet", options->isQuiet, "Print only errors");
  command->callback([options, &status] {
    options->outputs.picture.threads = options->threads;
    status = exportSnapshot(*options);
  });
}

}  // namespace espalier::command

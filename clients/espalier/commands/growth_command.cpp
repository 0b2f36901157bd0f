#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/output/growth_plot.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/gallery.h"

namespace espalier::command {
namespace {

struct GrowthOptions {
  ModelOptions model;
  std::vector<std::string> models;
  std::string plot;  // SVG; empty: none
};

// the lengths of a model's strings from step 0 to its last; nothing when it cannot be run
std::optional<GrowthCurve> curveOf(const GrowthOptions& options, const std::string& file) {
  server::DiskFileProvider files;
  ModelOptions model = options.model;
  model.model = file;
  std::optional<LoadedModel> loaded = loadModel(model, files);
  if (!loaded) {
    return std::nullopt;
  }
  simulation::Simulation simulation(loaded->program, {turtle::PlantPlacement{}}, std::move(loaded->environment.process),
                                    std::move(loaded->simulationOptions));
  GrowthCurve curve{std::filesystem::path(file).filename().string(), {}};
  std::optional<core::SimulationError> failure = simulation.rewind();
  while (!failure) {
    curve.lengths.push_back(simulation.string().size());
    if (server::isOver(simulation, model.steps)) {
      return curve;
    }
    failure = simulation.step();
  }
  printError(formatSimulationError(*failure));
  return std::nullopt;
}

int growth(const GrowthOptions& options) {
  std::vector<GrowthCurve> curves;
  for (const std::string& file : options.models) {
    std::optional<GrowthCurve> curve = curveOf(options, file);
    if (!curve) {
      return kFailure;
    }
    for (std::size_t step = 0; step < curve->lengths.size(); ++step) {
      std::printf("%s\t%zu\t%llu\n", curve->name.c_str(), step, static_cast<unsigned long long>(curve->lengths[step]));
    }
    curves.push_back(std::move(*curve));
  }
  if (options.plot.empty()) {
    return kSuccess;
  }
  if (const auto problem = server::writeFileAtomically(options.plot, growthPlot(curves))) {
    printError(*problem);
    return kFailure;
  }
  if (!options.model.isQuiet) {
    printNote("wrote " + options.plot);
  }
  return kSuccess;
}

}  // namespace

void addGrowth(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("growth", "Print the lengths of the strings of models, step by step");
  command->footer(
      "Prints a line for each model and step: the name, the step and the number of modules, separated by TABs. With "
      "-o\n"
      "it also writes an SVG with a curve for each model and a logarithmic axis.\n"
      "Example: espalier growth plant-1.lsv plant-2.lsv -o plants.svg");
  auto options = std::make_shared<GrowthOptions>();
  command->add_option("models", options->models, "L-system files of any dialect, model folders, or names of models of the gallery")
      ->type_name("MODEL...")
      ->transform(server::pathOrGallery)
      ->required();
  addRunningOptions(*command, options->model);
  command->add_option("-o", options->plot, "The plot to write")->type_name("FILE.svg");
  command->add_flag("--quiet", options->model.isQuiet, "Print only results and errors");
  command->callback([options, &status] { status = growth(*options); });
}

}  // namespace espalier::command

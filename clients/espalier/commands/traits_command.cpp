#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/number_option.h"
#include "clients/espalier/result.h"
#include "clients/espalier/roots/root_system.h"
#include "clients/espalier/roots/root_traits.h"
#include "clients/espalier/roots/shoot_traits.h"
#include "clients/espalier/world_file.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/folder_settings.h"

namespace espalier::command {
namespace {

struct TraitsOptions {
  ModelOptions model;
  std::string up;       // x, y, z; empty: of the world, or y
  double ground = 0.0;  // its area; 0: that of the crown

  [[nodiscard]] int upAxis(const core::Vec3& ofWorld = {0.0, 1.0, 0.0}) const {
    if (!up.empty()) {
      return up == "x" ? 0 : up == "y" ? 1 : 2;
    }
    const double x = std::abs(ofWorld.x);
    const double y = std::abs(ofWorld.y);
    const double z = std::abs(ofWorld.z);
    return y >= x && y >= z ? 1 : x >= z ? 0 : 2;
  }
};

bool isRootFile(const std::string& file) {
  const std::filesystem::path suffix = std::filesystem::path(file).extension();
  return suffix == ".rsml" || suffix == ".tsv";
}

/// The table of a model after its last step; nothing after an error.
std::optional<std::string> tableOfModel(const TraitsOptions& options, server::DiskFileProvider& files) {
  ModelOptions model = options.model;
  std::optional<LoadedModel> loaded = loadModel(model, files);
  if (!loaded) {
    return std::nullopt;
  }
  const int up = options.upAxis(loaded->simulationOptions.world.up);
  const std::string unit = roots::unitOfLengths(loaded->simulationOptions.world.lengthUnit);
  simulation::Simulation simulation(loaded->programs, loaded->plants, std::move(loaded->environment.process),
                                    std::move(loaded->simulationOptions));
  std::optional<core::SimulationError> failure = simulation.rewind();
  while (!failure && !server::isOver(simulation, model.steps)) {
    failure = simulation.step();
  }
  if (!failure) {
    auto scene = simulation.scene();
    if (scene) {
      const std::string table = roots::traitTable(roots::traitsOf(roots::rootsOf(*scene), up), unit);
      try {
        turtle::Geometry geometry;
        turtle::appendGeometry(
            std::move(*scene), simulation.view(), [](std::uint32_t, std::uint64_t) { return core::SymbolId{0}; },
            geometry);
        return table + roots::shootTraitRows(roots::shootTraitsOf(geometry, up, options.ground), up, unit);
      } catch (const core::SimulationFailure& tooLarge) {
        failure = tooLarge.error();
      }
    } else {
      failure = scene.error();
    }
  }
  printError(formatSimulationError(*failure));
  return std::nullopt;
}

/// The first trait of a table that is not finite, with its order; empty: all are finite.
std::string infiniteTrait(const std::string& table) {
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t unit = line.rfind('\t');
    const std::size_t number = line.rfind('\t', unit - 1) + 1;
    const std::string value = line.substr(number, unit - number);
    if (value == "inf" || value == "-inf" || value == "nan" || value == "-nan") {
      return line.substr(0, line.find('\t'));
    }
  }
  return {};
}

int run(const TraitsOptions& options) {
  server::DiskFileProvider files;
  std::optional<std::string> table;
  if (isRootFile(options.model.model)) {
    const auto text = files.read(options.model.model);
    if (!text) {
      printError("there is no file '" + options.model.model + "': check the name and the working folder");
      return kFailure;
    }
    auto read = roots::readRoots(options.model.model, *text);
    if (!read) {
      printError(options.model.model + ", " + read.error());
      return kFailure;
    }
    if (!read->remark.empty()) {
      printNote("warning: '" + options.model.model + "': " + read->remark);
    }
    const bool isInWorld = !options.model.world.empty();
    const std::optional<turtle::World> world = loadWorld(options.model, {}, files);
    if (!world) {
      return kFailure;
    }
    if (const auto problem = isInWorld ? roots::convertTo(*read, world->lengthUnit) : std::nullopt) {
      printError(options.model.model + ": " + *problem);
      return kFailure;
    }
    const std::string unit = isInWorld && read->unit.empty() ? world->lengthUnit : read->unit;
    table = roots::traitTable(roots::traitsOf(*read, options.upAxis(world->up)), roots::unitOfLengths(unit));
  } else {
    table = tableOfModel(options, files);
  }
  if (!table) {
    return kFailure;
  }
  if (const std::string trait = infiniteTrait(*table); !trait.empty()) {
    printError("the trait '" + trait + "' is not a finite number: bound the lengths, widths and places of the plant");
    return kFailure;
  }
  std::cout << *table << std::flush;
  return kSuccess;
}

}  // namespace

void addTraits(CLI::App& program, int& status) {
  CLI::App* command =
      program.add_subcommand("traits", "Print lengths, topology, leaves and crown of a plant or a root system");
  command->footer(
      "Prints a table of traits by order: lengths, numbers of axes, diameters, height, width, and Fitter's topology.\n"
      "The unit of each is in the last column: that of the world (of a root system when --world gives one), or of the "
      "file\n(\"length\" when it has none).\n"
      "Of a model with leaves also their number, area, index and angles, and the extent of the crown.\n"
      "MODEL is a model, or a root system: a .rsml file, or a .tsv table with the columns node, parent, x, y, z.\n"
      "Examples:\n"
      "  espalier traits clients/gallery/roots-in-soil --seed 1\n"
      "  espalier traits roots.rsml --up z\n"
      "  espalier traits clients/gallery/lilac --ground 100");
  auto options = std::make_shared<TraitsOptions>();
  addReadingOptions(*command, options->model, true);
  addRunningOptions(*command, options->model);
  command->add_option("--up", options->up, "The axis of the height (default: the world's, or y)")
      ->check(CLI::IsMember({"x", "y", "z"}));
  addPositiveNumber(*command, "--ground",
                    "Area of the ground for the leaf area index (default: the crown seen from above)", "an area",
                    [options](double area) { options->ground = area; });
  command->callback([options, &status] { status = run(*options); });
}

}  // namespace espalier::command

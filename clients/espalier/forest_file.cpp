#include "clients/espalier/forest_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <random>
#include <system_error>
#include <utility>

#include "clients/espalier/json_file.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/world_file.h"
#include "engine/turtle/export/palette.h"
#include "server/remote/translation/translate.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

constexpr const char* kForestFile = "forest.json";

// the environment that a forest file holds, under the forest file's own name
class WithEnvironment final : public core::FileProvider {
 public:
  WithEnvironment(std::string name, std::string text, core::FileProvider& others)
      : name_(std::move(name)), text_(std::move(text)), others_(&others) {}
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    return name == name_ ? text_ : others_->read(name);
  }

 private:
  std::string name_;
  std::string text_;
  core::FileProvider* others_;
};

std::string besideForest(const std::string& forest, const std::string& file) {
  return (fs::path(forest).parent_path() / file).string();
}

bool loadModels(const protocol::ForestParams& forest, const std::string& file, const ModelOptions& options,
                const std::string& lengthUnit, core::FileProvider& files, LoadedModel& loaded) {
  std::vector<files::Palette> palettes;
  for (const protocol::NamedModel& model : forest.models) {
    ModelOptions own = options;
    own.model = besideForest(file, model.file);
    own.object.clear();
    own.view.clear();
    own.environment.clear();
    own.lengthUnit = lengthUnit;
    server::FolderSettings folder;
    auto program = loadProgram(own, files, &folder);
    if (!program) {
      return false;
    }
    loaded.programs.push_back(std::move(program));
    palettes.push_back(std::move(folder.palette));
  }
  loaded.folder.palette = simulation::joinedPalettes(loaded.programs, palettes);
  return true;
}

bool loadEnvironmentOf(const protocol::ForestParams& forest, const std::string& file, const ModelOptions& options,
                       core::FileProvider& files, LoadedModel& loaded) {
  std::optional<LoadedEnvironment> environment = LoadedEnvironment{};
  RemoteOptions ofForest = options.environmentOptions();
  ofForest.source = EnvironmentSource::Folder;
  if (!options.environment.empty()) {
    environment =
        loadEnvironment(options.environment, options.mode(), options.isQuiet, files, options.environmentOptions());
  } else if (!forest.environmentJson.empty()) {
    WithEnvironment both(file, forest.environmentJson, files);
    environment = loadEnvironment(file, options.mode(), options.isQuiet, both, ofForest);
  } else if (!forest.environmentFile.empty()) {
    environment =
        loadEnvironment(besideForest(file, forest.environmentFile), options.mode(), options.isQuiet, files, ofForest);
  }
  if (!environment) {
    return false;
  }
  loaded.environment = std::move(*environment);
  for (const auto& program : loaded.programs) {
    if (!warnAboutUnansweredQueries(*program, loaded.environment.process ? &loaded.environment : nullptr,
                                    options.isQuiet, options.remote.isStrict)) {
      return false;
    }
  }
  return true;
}

std::optional<turtle::World> worldOfForest(const protocol::ForestParams& forest, const std::string& file,
                                           const ModelOptions& options, core::FileProvider& files) {
  const std::string own = besideForest(file, kWorldFile);
  std::error_code error;
  if (options.world.empty() && forest.world) {
    return completeWorld(*forest.world, file, options, files);
  }
  return loadWorld(options, fs::is_regular_file(own, error) ? own : std::string(), files);
}

}  // namespace

std::optional<std::string> forestFileOf(const std::string& model) {
  std::error_code error;
  if (fs::path(model).extension() == ".json") {
    return model;
  }
  const fs::path inside = fs::path(model) / kForestFile;
  if (fs::is_directory(model, error) && fs::is_regular_file(inside, error) &&
      !fs::exists(fs::path(model) / "specifications", error)) {
    return inside.string();
  }
  return std::nullopt;
}

std::optional<LoadedModel> loadForest(const std::string& file, ModelOptions& options, core::FileProvider& files) {
  for (const auto& [value, name] :
       {std::pair{&options.object, "--object"}, {&options.view, "--view"}, {&options.startFile, "--from"}}) {
    if (!value->empty()) {
      printError(std::string(name) + " is for a single model: '" + file + "' lists several models");
      return std::nullopt;
    }
  }
  const std::optional<protocol::ForestParams> forest =
      decodeJsonFile(file, "forest file", files, protocol::decodeForestParams);
  if (!forest) {
    return std::nullopt;
  }
  auto world = worldOfForest(*forest, file, options, files);
  if (!world) {
    return std::nullopt;
  }
  if (forest->world || !options.world.empty()) {
    options.lengthUnit = world->lengthUnit;
  }
  LoadedModel loaded;
  if (!loadModels(*forest, file, options, world->lengthUnit, files, loaded)) {
    return std::nullopt;
  }
  if (!loadEnvironmentOf(*forest, file, options, files, loaded)) {
    return std::nullopt;
  }
  // the run: the command line wins over the file, the file over the models
  if (!options.steps) {
    options.steps = forest->derivationLength;
  }
  if (!options.seed) {
    options.seed = forest->seed;
  }
  loaded.program = loaded.programs.front();
  for (const auto& program : loaded.programs) {
    if (!options.seed && needsDrawnSeed(*program)) {
      options.seed = std::random_device{}();
      if (!options.isQuiet) {
        printNote("seed " + std::to_string(*options.seed));
      }
    }
  }
  loaded.simulationOptions = simulationOptionsFor(options, *loaded.program);
  loaded.simulationOptions.world = std::move(*world);
  const fs::path path(file);
  loaded.simulationOptions.name =
      path.filename() == kForestFile ? path.parent_path().filename().string() : path.stem().string();
  loaded.simulationOptions.environmentOrigin = loaded.environment.origin;
  loaded.simulationOptions.palette = loaded.folder.palette;
  loaded.simulationOptions.seeds = server::seedRules(forest->seeds);
  loaded.plants = server::plantOrigins(forest->models, forest->plants);
  loaded.isForest = true;
  return loaded;
}

}  // namespace espalier::command

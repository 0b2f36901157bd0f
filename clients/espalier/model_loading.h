#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/environment_loading.h"
#include "engine/core/identifiers.h"
#include "engine/core/limits.h"
#include "engine/core/streams.h"
#include "engine/language/program.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/export/text/rsml.h"
#include "server/remote/models/folder_settings.h"

namespace CLI {
class App;
}

namespace espalier::command {

/// Options of the command line about a model and its run.
struct ModelOptions {
  std::string model;        // a `.l` file, a model folder or a forest file
  std::string dialect;      // of the model's file; empty: found by its content
  std::string object;       // the command of the folder; empty: the first
  std::string view;         // empty: the view file of the folder, or the `.v` file beside the model
  std::string environment;  // empty: the environment of the folder, or the `.e` file beside the model
  std::optional<std::uint64_t> steps;
  std::optional<std::uint64_t> seed;
  std::string compatibility;         // "", "cpfg" or "cpfg-batch"
  std::vector<std::string> defines;  // NAME=VALUE
  std::vector<std::string> limits;   // NAME=NUMBER
  /// loadProgram() sets it for a file of roots; null: none.
  std::shared_ptr<const turtle::RsmlLabels> rootLabels;
  unsigned threads = 0;     // 0: as many as the process may use
  bool isAnimated = false;  // the animation file decides which step is the last
  std::string startFile;    // string that takes the axiom's place; empty: none
  RemoteOptions remote;
  simulation::Coupling coupling;
  std::string world;         // a file; empty: that of the folder or of the forest, or the default
  std::string stepDuration;  // such as 1 h; empty: that of the world
  std::string lengthUnit;    // of the world, once it is loaded; empty: no file says it
  bool isQuiet = false;

  [[nodiscard]] core::Compatibility mode() const;
  [[nodiscard]] core::Limits simulationLimits() const;
  /// `threads`, or as many as the process may use.
  [[nodiscard]] unsigned threadCount() const;
  /// `remote`, with threadCount() for the environment of one run.
  [[nodiscard]] RemoteOptions environmentOptions() const;
  /// Seconds of processor time for the whole run; 0: no limit.
  [[nodiscard]] std::uint64_t seconds() const;
};

/// The entries of a model file with several models; empty: the file holds one, or options.model is no plain file.
[[nodiscard]] std::vector<std::string> modelEntries(const ModelOptions& options, core::FileProvider& files);

/// Adds the options for reading a model: MODEL, --object, --view, --environment, --compat, --define,
/// --allow-folder-programs, --strict, --limit, --quiet.
void addReadingOptions(CLI::App& command, ModelOptions& options, bool isModelRequired);
/// Adds the options for running it: --steps, --animate, --environment-policy, --environment-timeout, --iterations,
/// --tolerance, --seed, --from, --world, --step-duration, --threads.
void addRunningOptions(CLI::App& command, ModelOptions& options);
/// Adds --world and --step-duration, which world_file.h reads.
void addWorldOptions(CLI::App& command, std::string& world, std::string& stepDuration);

/// `NAME=VALUE` as in the option -D of a preprocessor: without `=` the value is 1.
[[nodiscard]] std::pair<std::string, std::string> splitDefine(const std::string& text);

/// Whether the program draws random numbers.
[[nodiscard]] bool drawsRandomNumbers(const language::Program& program);

/// Whether a run of the program depends on a seed that neither the model nor the caller gave.
[[nodiscard]] bool needsDrawnSeed(const language::Program& program);

/// Reads and compiles the model of `options` and completes options.view and options.environment with the files beside
/// it. A root system is given in options.lengthUnit, which is the file's own when it is empty.
/// `folder`, when not null, receives its colours and animation. Prints diagnostics and errors on standard error.
/// Returns null after an error.
[[nodiscard]] std::shared_ptr<const language::Program> loadProgram(ModelOptions& options, core::FileProvider& files,
                                                                   server::FolderSettings* folder = nullptr);

/// A model ready to run. The environment's process is null when there is none.
struct LoadedModel {
  std::shared_ptr<const language::Program> program;  // the first
  simulation::Programs programs;                     // of a forest several
  std::vector<simulation::PlantOrigin> plants;
  bool isForest = false;  // from a forest file
  server::FolderSettings folder;
  LoadedEnvironment environment;
  simulation::SimulationOptions simulationOptions;
};

/// Loads a forest (forest_file.h) or a model with its environment and the options of the simulation. Draws a seed, and
/// prints it, when the model needs one. Returns nothing after an error.
[[nodiscard]] std::optional<LoadedModel> loadModel(ModelOptions& options, core::FileProvider& files);

/// The simulation options. Draws a seed, and prints it on standard error, when the model needs one.
[[nodiscard]] simulation::SimulationOptions simulationOptionsFor(const ModelOptions& options,
                                                                 const language::Program& program);

}  // namespace espalier::command

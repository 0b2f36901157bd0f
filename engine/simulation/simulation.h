#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/core/limits.h"
#include "engine/core/simulation_error.h"
#include "engine/core/streams.h"
#include "engine/derivation/derivation.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/files/colour_files.h"
#include "engine/language/program.h"
#include "engine/simulation/forest.h"
#include "engine/turtle/environment_process.h"
#include "engine/turtle/interpretation/interpreter.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::simulation {

struct PlantsView;

/// The reaction to an environment that does not answer.
enum class EnvironmentPolicy : std::uint8_t {
  Fail,  // the step fails, the simulation stays at its last completed step
  Keep,  // the modules keep what they sent
};

/// The caller's own description of the environment: its name and the files of its configuration. A snapshot keeps it,
/// so that the program that resumes can make the same environment again.
struct EnvironmentOrigin {
  std::string name;                                        // empty: not given
  std::vector<std::pair<std::string, std::string>> files;  // name, text

  bool operator==(const EnvironmentOrigin&) const = default;
};

/// Iterated (implicit) coupling: within a step the environment returns to its state before the step and answers queries
/// that hold its last answers, until the answers no longer change. ?E(x) then is a fixed point of both sides.
struct Coupling {
  std::uint32_t iterations = 1;  // maximum number of exchanges in a step; 1: not iterated
  double tolerance = 0.0;        // a parameter that changes by no more than this stays as it is; 0: the same bits

  bool operator==(const Coupling&) const = default;
};

struct SimulationOptions {
  std::string name = "simulation";
  std::uint64_t seed = 0;
  bool hasSeed = false;                           // given by the caller: replaces `seed:`
  std::optional<std::uint64_t> derivationLength;  // replaces the model's
  unsigned threads = 1;                           // 0 is 1: the caller knows how many the process may use
  core::Limits limits;
  turtle::World world;  // of a new run; a restored snapshot brings its own
  Coupling coupling;    // of a new run; a restored snapshot brings its own
  EnvironmentPolicy environmentPolicy = EnvironmentPolicy::Fail;
  EnvironmentOrigin environmentOrigin;
  SeedRules seeds;          // where the seeds that plants drop take root
  files::Palette palette;   // colours of the model folder: for pictures only, snapshots carry them
  std::string startString;  // takes the axiom's place in every plant, as its text; empty: the axiom
  core::MessageSink messages;
  std::shared_ptr<core::FileWriter> fileWriter;  // receives the output of models after each step; null: none
};

/// Figures of the last step, or summed over a run.
struct StepStatistics {
  std::uint64_t step = 0;     // completed steps after it
  std::uint64_t modules = 0;  // of all plants
  std::uint64_t parameters = 0;
  std::uint64_t queries = 0;
  std::uint64_t answers = 0;     // queries with a reply that set something
  std::uint64_t bytes = 0;       // of the strings
  std::uint32_t iterations = 0;  // exchanges with the environment in the last step
  std::uint64_t plants = 0;      // that live
  std::uint64_t births = 0;      // seeds that took root in the step
  std::uint64_t deaths = 0;      // plants that ended in the step
};

/// How often one production was applied.
struct ProductionUse {
  std::uint64_t last = 0;   // in the last step
  std::uint64_t total = 0;  // in the steps of the run
};

/// The productions that a run has applied. Those of homomorphism do not count.
struct ProductionUses {
  std::uint64_t since = 0;                                              // the steps behind this one were counted
  std::uint64_t step = 0;                                               // up to this one
  std::unordered_map<const language::Production*, ProductionUse> uses;  // of all Programs; none: never applied
};

/// One plant or several, of one Program or several, with an environment, advanced together. Not thread-safe: one worker
/// at a time.
///
/// Plants come and go during a run (forest.h). A seed that takes root becomes a plant at the end of the step. A plant
/// that asks for its death is gone at the end of the step. A plant keeps its number; the string of a dead plant is
/// empty.
///
/// A step: queries of all plants -> environment -> write back -> derive each plant. After a failure everything is as
/// after the last completed step, and the step can be tried again. Replies that have arrived are kept: the environment
/// is not asked twice.
class Simulation {
 public:
  Simulation(std::shared_ptr<const language::Program> program, std::vector<turtle::PlantPlacement> placements,
             std::unique_ptr<turtle::EnvironmentProcess> environment, SimulationOptions options);
  /// A forest: plants of several Programs, which must have one compatibility mode. Plants are numbered by where they
  /// stand (x, then y, then z, then how they are turned, then model), whatever the order of `plants`: neither random
  /// numbers nor anything else depends on that order. `programs` must not be empty. With several Programs the
  /// derivation length is the longest of them unless the options say otherwise.
  Simulation(Programs programs, std::vector<PlantOrigin> plants,
             std::unique_ptr<turtle::EnvironmentProcess> environment, SimulationOptions options);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Goes to step 0: Start, axiom, environment opened. Must be called (or a snapshot restored) before the first step.
  [[nodiscard]] std::optional<core::SimulationError> rewind();
  /// The same with another seed, which from now on replaces the model's. Run after run of one simulation costs less
  /// than a simulation for each run, and gives the same bits. After a failure the seed is as before.
  [[nodiscard]] std::optional<core::SimulationError> rewind(std::uint64_t seed);

  /// One step; setCancelled(true) from another thread cancels it. A step beyond the derivation length is allowed. A
  /// step after the model has stopped itself is an error.
  [[nodiscard]] std::optional<core::SimulationError> step();

  /// Only the interpretation pass of the next step: answers are written into the strings, and nothing is derived.
  /// step() does not repeat the pass. `derive --answered` prints the strings after it, and a model with `environment
  /// display: before` is shown after it. The strings do not depend on when the pass is made.
  [[nodiscard]] std::optional<core::SimulationError> answer();

  /// The derivation length is reached or the model called stop().
  [[nodiscard]] bool isFinished() const;
  /// The strings hold the replies of the pass before the next step.
  [[nodiscard]] bool isAnswered() const;
  /// The seed of the run: the caller's when given, else the model's `seed:`, else SimulationOptions::seed.
  [[nodiscard]] std::uint64_t seed() const;
  [[nodiscard]] std::uint64_t completedSteps() const;
  [[nodiscard]] std::uint64_t derivationLength() const;
  [[nodiscard]] std::size_t plantCount() const;  // living and dead
  [[nodiscard]] std::uint64_t livingPlantCount() const;
  [[nodiscard]] const Plant& plant(std::size_t plant) const;
  [[nodiscard]] const derivation::ModuleString& string(std::size_t plant = 0) const;
  /// Everything that the next derivation of a plant starts from.
  [[nodiscard]] const derivation::PlantState& plantState(std::size_t plant = 0) const;
  /// The options of its Derivation.
  [[nodiscard]] derivation::DerivationOptions derivationOptions(std::size_t plant = 0) const;
  [[nodiscard]] std::string stringText(std::size_t plant = 0) const;
  [[nodiscard]] const StepStatistics& statistics() const;
  /// Bytes of memory that a step keeps for the next one, beside strings and environment. At most 32 for each module,
  /// and 4 MB for the counts of productions unless a step applies more than 65,536 of them.
  [[nodiscard]] std::uint64_t keptBytes() const;
  /// The Program of a plant; of a simulation without plants the first.
  [[nodiscard]] const language::Program& program(std::size_t plant = 0) const;
  [[nodiscard]] const Programs& programs() const;
  /// Names of the symbols by the numbers of turtleRecords() and of the queries to the environment.
  [[nodiscard]] const std::vector<std::string>& symbolNames() const;
  /// The view settings for scene(): those of the first Program, with the surfaces and contours of all Programs. Valid
  /// as long as the simulation.
  [[nodiscard]] const files::ViewSettings& view() const;
  [[nodiscard]] const SimulationOptions& options() const;
  [[nodiscard]] turtle::EnvironmentProcess* environment();  // null: none
  void setCancelled(bool isCancelled);                      // from any thread

  /// Draws all plants. Does not change the simulation (homomorphism side effects happen on a copy of the variables).
  [[nodiscard]] tl::expected<turtle::Scene, core::SimulationError> scene() const;
  /// The turtle stream's records of the current strings, all plants; symbols are places in symbolNames(). Does not
  /// change the simulation.
  [[nodiscard]] tl::expected<std::vector<turtle::TurtleRecord>, core::SimulationError> turtleRecords() const;
  /// Calls `visit` after each module of all plants, in order, with the turtle's state then (InterpretationOutput::
  /// onModule). Does not change the simulation.
  [[nodiscard]] std::optional<core::SimulationError> visitModules(
      const std::function<void(const turtle::TurtleRecord&, std::uint64_t first)>& visit) const;

  /// The plants as they are now, for other threads (plants_view.h). Copies no string: O(plants).
  [[nodiscard]] std::shared_ptr<const PlantsView> takeView();
  /// Whether the next views tell what changed since the view before each of them. Costs each step a little.
  void followChanges(bool isWanted);
  /// Whether the steps from now on count how often they apply each production. They take no shortcuts then, and derive
  /// a long string several times as slowly, with the same result. After rewind() and restore() the counts are those
  /// that the run had at the step, of the last 1000 or fewer, or begin anew.
  void countProductions(bool isWanted);
  /// At the present step. Null: not counted. Other threads may read it, as long as the Programs live.
  [[nodiscard]] std::shared_ptr<const ProductionUses> productionUses() const;

  /// Whether the steps from now on note which modules continue which (derivation::ModuleOrigins). They take no
  /// shortcuts then, as with countProductions(), and the simulation keeps 16 bytes a module. Call it before rewind() or
  /// restore().
  void followAges(bool isWanted);
  /// By module of the plant's string: the step in which it came; kUnknownBirth: before a snapshot that was restored.
  /// Empty: not followed. Valid until the next step.
  static constexpr std::uint64_t kUnknownBirth = ~std::uint64_t{0};
  [[nodiscard]] std::span<const std::uint64_t> moduleBirths(std::size_t plant) const;

  /// Hash of the complete state: strings, variables, random streams, environment.
  [[nodiscard]] std::uint64_t stateHash() const;
  /// Hash of the plants alone: strings, variables, random streams. The environment is not asked.
  [[nodiscard]] std::uint64_t plantsHash() const;

  /// Writes the complete state: sources and options of the Program, plants, environment. Versioned (snapshot.h).
  void save(core::ByteSink& sink) const;
  /// Replaces the state by a snapshot's, placements included. The snapshot must be of the same Program and the same
  /// environment by name; seed and derivation length become the snapshot's. On failure nothing changes.
  [[nodiscard]] std::optional<core::SimulationError> restore(std::string_view snapshot);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace espalier::simulation

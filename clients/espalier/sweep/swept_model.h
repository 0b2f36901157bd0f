#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clients/espalier/result.h"
#include "clients/espalier/sweep/measures.h"
#include "clients/espalier/sweep/plan.h"
#include "clients/espalier/sweep/start_values.h"
#include "clients/espalier/sweep/swept_environment.h"
#include "engine/core/streams.h"
#include "engine/files/colour_files.h"
#include "engine/language/program.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/world.h"

namespace espalier::command {

/// The common input of the runs of a plan, as the caller has found it: the files of the model and its environment.
struct SweepInput {
  Plan plan;
  language::CompileInput model;  // without the macros that the parameters set
  std::string configuration;     // JSON text of the list of environments; empty: environmentMaker
  EnvironmentMaker environmentMaker;
  files::Palette palette;
  turtle::World world{};
  std::string worldText{};  // tells the world from others; empty: nothing says what it is
};

/// One variant of the model: the Program for a set of macros.
struct ModelVariant {
  std::shared_ptr<const language::Program> program;
  Measures measures;
  std::string warning{};  // the first of the compiler that the model without the parameters does not have
};

/// The model of a sweep: its parameters found, and compiled once for each set of macros. Several threads may use it.
class SweptModel {
 public:
  /// Compiles the model for the first row and finds every parameter. `files` must outlive the object, and several
  /// threads may read from it. A problem has a line for each mistake.
  [[nodiscard]] static Result<std::unique_ptr<SweptModel>> make(SweepInput input, std::span<const double> firstRow,
                                                                core::FileProvider& files);

  /// The variant for a row of parameters. The text of the first error when the model does not compile with it.
  [[nodiscard]] Result<std::shared_ptr<const ModelVariant>> variantFor(std::span<const double> row);

  [[nodiscard]] const SweepInput& input() const { return input_; }
  [[nodiscard]] const Plan& plan() const { return input_.plan; }
  [[nodiscard]] const std::vector<std::string>& measureColumns() const { return first_->measures.columns(); }
  /// Identifies model, macros of the plan, environment and version of the program: results of two sweeps with equal
  /// identities are comparable.
  [[nodiscard]] const std::string& identity() const { return identity_; }
  /// Slots of the variables that parameters set, for variants of one set of macros; a problem when one is missing.
  [[nodiscard]] Result<std::vector<std::size_t>> variableSlots(const language::Program& program) const;

 private:
  class Sources;  // the files of the model as they were at the start
  SweptModel(SweepInput input, core::FileProvider& files);
  [[nodiscard]] Result<std::shared_ptr<const ModelVariant>> compile(std::span<const double> row) const;
  [[nodiscard]] language::CompileInput inputFor(std::span<const double> row) const;
  [[nodiscard]] std::optional<std::string> findParameters(const language::Program& program);
  [[nodiscard]] std::optional<std::string> findLateMeasures() const;

  SweepInput input_;
  std::shared_ptr<Sources> sources_;
  std::string identity_;
  std::vector<std::string> knownWarnings_;  // of the model without the parameters, which the caller has shown
  std::shared_ptr<const ModelVariant> first_;
  mutable std::mutex mutex_;
  // with mutex_ held: variants by the values of their macros, the newest in front
  std::list<std::pair<std::vector<double>, std::shared_ptr<const ModelVariant>>> variants_;
};

/// The result of one run.
struct RunOutcome {
  std::vector<double> values;  // by measure; not a number: the plant has no such value
  std::string error;           // empty: the run reached its end
  std::string warning;         // the first of the run that the runner has not given before; not kept in results
  double seconds = 0.0;        // wall time
};

/// Called with a finished plant, for files that are kept. A sentence when it fails.
using PlantVisitor = std::function<std::optional<std::string>(const simulation::Simulation&, std::uint64_t run)>;

/// Makes runs of a model one after another: one worker. Runs of one Program and one environment share a simulation,
/// which is set back for each of them.
class ModelRunner {
 public:
  /// `model` must outlive the object.
  explicit ModelRunner(SweptModel& model);
  ModelRunner(const ModelRunner&) = delete;
  ModelRunner& operator=(const ModelRunner&) = delete;

  /// One run. `run` is its number, for `visit`, which may be empty.
  [[nodiscard]] RunOutcome run(std::span<const double> row, std::uint64_t seed, std::uint64_t run,
                               const PlantVisitor& visit);

 private:
  [[nodiscard]] std::optional<std::string> prepare(std::span<const double> row);
  [[nodiscard]] std::optional<std::string> prepareVariant(std::span<const double> row);
  [[nodiscard]] std::optional<std::string> prepareEnvironment(std::span<const double> row);
  [[nodiscard]] std::string grow(std::uint64_t seed, std::uint64_t run, const PlantVisitor& visit,
                                 std::vector<double>& values);

  SweptModel& model_;
  SweptEnvironment environment_;
  std::shared_ptr<const ModelVariant> variant_;
  std::optional<StartValues> startValues_;  // of variant_, when parameters are variables
  std::string warning_;                     // of the present run
  // of variant_ and the process of environment_; null: the next run makes it
  std::unique_ptr<simulation::Simulation> simulation_;
};

}  // namespace espalier::command

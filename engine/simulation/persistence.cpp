#include <algorithm>
#include <utility>

#include "engine/core/hash.h"
#include "engine/simulation/simulation_implementation.h"
#include "engine/simulation/snapshot.h"
#include "engine/simulation/snapshot_check.h"

namespace espalier::simulation {
namespace {

SnapshotModel snapshotModelOf(const language::Program& program) {
  SnapshotModel model;
  model.modelFile = program.modelFile;
  model.viewFile = program.viewFile;
  model.defines = program.defines;
  for (const files::SourceMap::File& file : program.sources) {
    model.sources.emplace_back(file.name, file.text);
  }
  model.programHash = program.hash;
  for (const language::ModuleType& type : program.types) {
    model.types.emplace_back(program.symbols[type.symbol].name, type.arity);
  }
  return model;
}

}  // namespace

std::uint64_t Simulation::Implementation::stateHash() const {
  core::Hasher hasher;
  for (const auto& program : models_.programs()) {
    hasher.integer(program->hash);
  }
  hasher.integer(completedSteps_);
  hasher.integer(transaction_.isAnswered() ? 1 : 0);
  population_.hash(hasher);
  if (environment_.exists() && isStarted_) {
    hasher.bytes(environment_.save());
  }
  return hasher.value();
}

std::uint64_t Simulation::Implementation::plantsHash() const {
  core::Hasher hasher;
  population_.hash(hasher);
  return hasher.value();
}

void Simulation::Implementation::save(core::ByteSink& sink) const {
  SnapshotContent content;
  content.compatibility = models_.compatibility();
  content.models.clear();
  for (const auto& program : models_.programs()) {
    content.models.push_back(snapshotModelOf(*program));
  }
  content.name = options_.name;
  content.seed = options_.seed;
  content.hasSeed = options_.hasSeed;
  content.derivationLength = population_.derivationLength();
  content.completedSteps = completedSteps_;
  content.members = population_.members();
  content.seeds = options_.seeds;
  content.palette = options_.palette;
  content.coupling = options_.coupling;
  content.world = options_.world;
  // a snapshot holds the state before the answers; replies go with it and are written again when it is restored
  const std::vector<derivation::PlantState>& states = population_.states();
  for (std::size_t plant = 0; plant < states.size(); ++plant) {
    content.plants.push_back(transaction_.before(plant, states[plant]));
  }
  if (environment_.exists()) {
    content.environmentName = environment_.description().name;
    content.environmentOrigin = options_.environmentOrigin;
    content.environmentState = isStarted_ ? environment_.save() : std::string();
  }
  content.isAnswered = transaction_.isAnswered();
  content.hasReplies = transaction_.answer().hasReplies;
  content.hasTicked = transaction_.answer().hasTicked;
  if (content.hasReplies) {
    content.replies = transaction_.answer().replies;
  }
  writeSnapshot(content, sink);
}

Simulation::Implementation::Outcome Simulation::Implementation::restore(std::string_view snapshot) {
  // read and check everything before anything changes
  auto read = readSnapshot(snapshot, false);
  if (!read) {
    return failed(std::move(read.error()));
  }
  SnapshotContent& content = *read;
  if (auto error = sizeErrorOf(content, options_.limits)) {
    return failed(std::move(*error));
  }
  std::string problem = adoptPrograms(content, models_.programs(), options_.limits);
  if (problem.empty()) {
    problem = problemOfEnvironment(content);
  }
  return problem.empty() ? resume(content) : failed(snapshotError(std::move(problem)));
}

std::string Simulation::Implementation::problemOfEnvironment(const SnapshotContent& content) const {
  const std::string& ownName = environment_.description().name;
  const bool isKnown = ownName != kUnknownEnvironment && content.environmentName != kUnknownEnvironment;
  const bool isOneMissing = ownName.empty() != content.environmentName.empty();
  if (content.environmentName == ownName || (!isKnown && !isOneMissing)) {
    return {};
  }
  const auto named = [](const std::string& name) {
    return name.empty() ? std::string("no environment") : "environment '" + name + "'";
  };
  return "The snapshot was made with " + named(content.environmentName) + " and the simulation has " + named(ownName) +
         ". Give it the one it was made with.";
}

/// Puts another run in place of this one, and returns this one.
Simulation::Implementation::Run Simulation::Implementation::exchangeRun(Run run) {
  std::swap(options_, run.options);
  viewOptions_ = nullptr;
  drawing_.forget();
  std::swap(population_, run.population);
  std::swap(transaction_, run.transaction);
  std::swap(births_, run.births);
  std::swap(statistics_, run.statistics);
  std::swap(completedSteps_, run.completedSteps);
  std::swap(isStarted_, run.isStarted);
  std::string name = environment_.description().name;
  environment_.setName(std::exchange(run.environmentName, std::move(name)));
  return run;
}

/// Continues the run of a snapshot that fits. When the environment refuses it, or the replies that go with it cannot be
/// written, the run before goes on.
Simulation::Implementation::Outcome Simulation::Implementation::resume(SnapshotContent& content) {
  Run next{.options = options_,
           .population = Population(models_, derivations_, {}),
           .transaction = StepTransaction(content.members.size(),
                                          {content.hasReplies, content.hasTicked, std::move(content.replies)}),
           .completedSteps = content.completedSteps,
           .environmentName = environment_.description().name};
  next.options.seed = content.seed;
  next.options.hasSeed = content.hasSeed;
  next.options.coupling = content.coupling;
  next.options.world = content.world;
  next.options.seeds = content.seeds;
  if (next.options.palette.empty()) {
    next.options.palette = std::move(content.palette);
  }
  const std::string environmentBefore = environment_.exists() && isStarted_ ? environment_.save() : std::string();
  Run before = exchangeRun(std::move(next));
  const auto goBack = [&] {
    before = exchangeRun(std::move(before));
    changes_.forget();
    if (environment_.exists() && isStarted_) {
      static_cast<void>(environment_.restore(environmentBefore));
    }
  };
  try {
    // the derivations read the options of the run
    population_ = Population(models_, derivations_, std::move(content.members));
    if (const auto error = resumeEnvironment(content, before)) {
      goBack();
      return failed(snapshotError("The environment's state in the snapshot cannot be restored: " + error->message));
    }
    population_.setStates(std::move(content.plants));
    isStarted_ = true;
    countStrings();
    noteRestored(before);
    if (content.isAnswered) {
      answerQueries();
    }
    productions_.goTo(completedSteps_);
    ages_.goTo(population_.states(), ModuleAges::kUnknown);
    return std::nullopt;
  } catch (const core::SimulationFailure& failure) {
    goBack();
    return failed(failure.error());
  } catch (...) {
    goBack();
    throw;
  }
}

/// Says how the strings differ from those of the run before.
void Simulation::Implementation::noteRestored(const Run& before) {
  // the plants may stand elsewhere
  changes_.forget(ChangeReader::Queries);
  if (!changes_.isFollowed()) {
    return;
  }
  const std::vector<derivation::PlantState>& old = before.population.states();
  for (std::size_t plant = 0; plant < std::min(old.size(), population_.size()); ++plant) {
    changes_.add(plant, derivation::StepChanges::between(old[plant].string, population_.states()[plant].string,
                                                         population_.program(plant).arity));
  }
}

std::optional<turtle::EnvironmentError> Simulation::Implementation::resumeEnvironment(const SnapshotContent& content,
                                                                                      const Run& before) {
  if (!environment_.exists()) {
    return std::nullopt;
  }
  std::optional<turtle::EnvironmentError> error;
  if (!before.isStarted || population_.size() != before.population.size() || options_.world != before.options.world) {
    error = environment_.open(environmentContext());
  }
  if (!error) {
    error = environment_.restore(content.environmentState);
  }
  if (!error && environment_.description().name == kUnknownEnvironment) {
    environment_.setName(content.environmentName);
  }
  return error;
}

}  // namespace espalier::simulation

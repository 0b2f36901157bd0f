#include <utility>

#include "engine/core/hash.h"
#include "engine/derivation/state/string_text.h"
#include "engine/simulation/simulation_implementation.h"
#include "engine/simulation/snapshot.h"
#include "engine/simulation/snapshot_check.h"
#include "engine/turtle/guarded_call.h"

namespace espalier::simulation {

namespace {

void hashPlant(core::Hasher& hasher, const language::Program& program, const derivation::PlantState& plant) {
  hasher.integer(derivation::hashOf(program, plant.string));
  hasher.integer(plant.step);
  hasher.integer(plant.derivationLength);
  hasher.integer(plant.isStopped ? 1 : 0);
  for (const double value : plant.statics) {
    hasher.number(value);
  }
  for (const derivation::InstanceState& instance : plant.instances) {
    hasher.integer(instance.system);
    hasher.integer(instance.hasStarted ? 1 : 0);
    for (const double value : instance.variables) {
      hasher.number(value);
    }
    for (const double value : instance.elements) {
      hasher.number(value);
    }
  }
  hasher.integer(plant.random.seed);
  hasher.integer(plant.random.mainSeed);
  hasher.integer(plant.random.selection.state());
  hasher.integer(plant.random.main.state());
  hasher.number(plant.random.normalCache);
  hasher.number(plant.random.normalCacheFlag);
  for (const derivation::OpenFile& file : plant.files.open) {
    hasher.integer(file.file);
    hasher.integer(file.mode.bits());
    hasher.integer(file.position);
    hasher.integer(file.isOpen ? 1 : 0);
  }
  for (const derivation::KeptFile& file : plant.files.kept) {
    hasher.integer(file.file);
    hasher.integer(file.text.size());
    hasher.bytes(file.text);
  }
}

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

void Simulation::Implementation::hashPlants(core::Hasher& hasher) const {
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    const Plant& member = members_[plant];
    if (member.birthStep != 0 || !member.isAlive()) {
      hasher.integer(member.birthStep);
      hasher.integer(member.deathStep);
      hasher.number(member.origin.placement.position.x);
      hasher.number(member.origin.placement.position.y);
      hasher.number(member.origin.placement.position.z);
    }
    hashPlant(hasher, programOf(plant), plants_[plant]);
  }
}

std::uint64_t Simulation::Implementation::stateHash() const {
  core::Hasher hasher;
  for (const auto& program : models_.programs()) {
    hasher.integer(program->hash);
  }
  hasher.integer(completedSteps_);
  hasher.integer(isAnswered_ ? 1 : 0);
  hashPlants(hasher);
  if (environment_ && isStarted_) {
    hasher.bytes(environment_->save());
  }
  return hasher.value();
}

std::uint64_t Simulation::Implementation::plantsHash() const {
  core::Hasher hasher;
  hashPlants(hasher);
  return hasher.value();
}

void Simulation::Implementation::save(core::ByteSink& sink) {
  SnapshotContent content;
  content.compatibility = models_.compatibility();
  content.models.clear();
  for (const auto& program : models_.programs()) {
    content.models.push_back(snapshotModelOf(*program));
  }
  content.name = options_.name;
  content.seed = options_.seed;
  content.hasSeed = options_.hasSeed;
  content.derivationLength = derivationLength();
  content.completedSteps = completedSteps_;
  content.members = members_;
  content.seeds = options_.seeds;
  content.palette = options_.palette;
  content.coupling = options_.coupling;
  // a snapshot holds the state before the answers; replies go with it and are written again when it is restored
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    content.plants.push_back(plants_[plant]);
    StepUndo undo = undo_[plant];
    undo.apply(content.plants.back());
  }
  if (environment_) {
    content.environmentName = description_.name;
    content.environmentOrigin = options_.environmentOrigin;
    content.environmentState = isStarted_ ? environment_->save() : std::string();
  }
  content.isAnswered = isAnswered_;
  content.hasReplies = pending_.hasReplies;
  content.hasTicked = pending_.hasTicked;
  if (pending_.hasReplies) {
    content.replies = pending_.replies;
  }
  writeSnapshot(content, sink);
}

Simulation::Implementation::Outcome Simulation::Implementation::restore(std::string_view snapshot) {
  // read and check everything before anything changes
  auto read = readSnapshot(snapshot, false);
  if (auto* error = std::get_if<core::SimulationError>(&read)) {
    return failed(std::move(*error));
  }
  SnapshotContent& content = std::get<SnapshotContent>(read);
  if (std::string problem = adoptPrograms(content, models_.programs(), options_.limits); !problem.empty()) {
    return failed(snapshotError(std::move(problem)));
  }
  const std::string ownName = environment_ ? description_.name : std::string();
  const bool isKnown = ownName != kUnknownEnvironment && content.environmentName != kUnknownEnvironment;
  if (content.environmentName != ownName && (isKnown || ownName.empty() || content.environmentName.empty())) {
    const auto named = [](const std::string& name) {
      return name.empty() ? std::string("no environment") : "environment '" + name + "'";
    };
    return failed(snapshotError("The snapshot was made with " + named(content.environmentName) +
                                " and the simulation has " + named(ownName) + ". Give it the one it was made with."));
  }
  // the environment next: it can refuse
  const SimulationOptions oldOptions = options_;
  const std::vector<Plant> oldMembers = members_;
  const auto adopt = [this](const SimulationOptions& options, std::vector<Plant> members) {
    undo_.clear();
    options_.name = options.name;
    options_.seed = options.seed;
    options_.hasSeed = options.hasSeed;
    options_.palette = options.palette;
    options_.coupling = options.coupling;
    options_.seeds = options.seeds;
    members_ = std::move(members);
    makeDerivations();
  };
  SimulationOptions newOptions = options_;
  newOptions.seed = content.seed;
  newOptions.hasSeed = content.hasSeed;
  newOptions.coupling = content.coupling;
  newOptions.seeds = content.seeds;
  if (newOptions.palette.empty()) {
    newOptions.palette = std::move(content.palette);
  }
  const std::vector<StepUndo> oldUndo = undo_;
  const bool wasStarted = isStarted_;
  adopt(newOptions, std::move(content.members));
  if (environment_) {
    const std::string oldState = wasStarted ? environment_->save() : std::string();
    std::optional<turtle::EnvironmentError> error;
    if (!wasStarted || members_.size() != oldMembers.size()) {
      error = turtle::guardedCall(ownName, [&] { return environment_->open(environmentContext()); });
    }
    if (!error) {
      error = turtle::guardedCall(ownName, [&] { return environment_->restore(content.environmentState); });
    }
    if (error) {
      adopt(oldOptions, oldMembers);
      undo_ = oldUndo;
      if (wasStarted) {
        static_cast<void>(environment_->restore(oldState));
      }
      return failed(snapshotError("The environment's state in the snapshot cannot be restored: " + error->message));
    }
  }
  if (environment_ && description_.name == kUnknownEnvironment) {
    description_.name = content.environmentName;
  }
  // then the state
  forgetLife();
  plants_ = std::move(content.plants);
  completedSteps_ = content.completedSteps;
  pending_ = Pending{content.hasReplies, content.hasTicked, std::move(content.replies)};
  isStarted_ = true;
  isAnswered_ = false;
  statistics_ = StepStatistics{};
  countStrings();
  return content.isAnswered ? answer() : std::nullopt;
}

}  // namespace espalier::simulation

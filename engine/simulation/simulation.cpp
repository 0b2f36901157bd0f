#include "engine/simulation/simulation.h"

#include <algorithm>
#include <new>
#include <utility>

#include "engine/core/check.h"
#include "engine/derivation/model_files.h"
#include "engine/derivation/string_text.h"
#include "engine/simulation/simulation_implementation.h"
#include "engine/turtle/scene_bounds.h"

namespace espalier::simulation {

using Outcome = std::optional<core::SimulationError>;

Simulation::Implementation::Implementation(std::shared_ptr<const language::Program> program,
                                           std::vector<turtle::PlantPlacement> placements,
                                           std::unique_ptr<turtle::EnvironmentProcess> environment,
                                           SimulationOptions options)
    : program_(std::move(program)),
      placements_(std::move(placements)),
      environment_(std::move(environment)),
      options_(std::move(options)),
      interpreter_(*program_) {
  if (environment_) {
    description_ = environment_->describe();
  }
  makeDerivations();
}

std::uint64_t Simulation::Implementation::effectiveSeed() const {
  // the first L-system with a `seed:` item names the model's
  for (const language::LSystem& system : program_->systems) {
    if (!options_.hasSeed && system.seed) {
      return static_cast<std::uint64_t>(*system.seed);
    }
  }
  return options_.seed;
}

derivation::DerivationOptions Simulation::Implementation::derivationOptions(std::uint32_t plant) const {
  derivation::DerivationOptions options;
  options.seed = seed_;
  options.hasSeed = options_.hasSeed;
  options.plant = plant;
  options.derivationLength = options_.derivationLength;
  options.threads = options_.threads;
  options.limits = options_.limits;
  options.cancelled = &isCancelled_;
  options.messages = options_.messages;
  options.canWriteFiles = options_.fileWriter != nullptr;
  return options;
}

void Simulation::Implementation::makeDerivations() {
  seed_ = effectiveSeed();
  derivations_.clear();
  displayDerivations_.clear();
  for (std::uint32_t plant = 0; plant < placements_.size(); ++plant) {
    derivations_.emplace_back(*program_, derivationOptions(plant));
  }
  undo_.resize(placements_.size());
}

turtle::EnvironmentContext Simulation::Implementation::environmentContext() const {
  turtle::EnvironmentContext context;
  context.simulation = options_.name;
  context.plantCount = static_cast<std::uint32_t>(placements_.size());
  for (const language::Symbol& symbol : program_->symbols) {
    context.symbols.push_back(symbol.name);
  }
  context.seed = seed_;
  context.world = options_.world;
  return context;
}

void Simulation::Implementation::startFromString(derivation::PlantState& plant) const {
  auto read = derivation::parseText(*program_, options_.startString);
  if (const std::string* problem = std::get_if<std::string>(&read)) {
    core::SimulationError error;
    error.code = core::SimulationErrorCode::Model;
    error.message = "the string to start from, " + *problem + ".";
    throw core::SimulationFailure(std::move(error));
  }
  plant.string = std::move(std::get<derivation::ModuleString>(read));
}

Outcome Simulation::Implementation::rewind() {
  return guarded([this] {
    undoStep();
    // the plants first: a failing Start changes nothing
    std::vector<derivation::PlantState> plants(placements_.size());
    for (std::size_t plant = 0; plant < plants.size(); ++plant) {
      derivations_[plant].rewind(plants[plant]);
      if (!options_.startString.empty()) {
        startFromString(plants[plant]);
      }
    }
    if (environment_) {
      if (const auto error = environment_->open(environmentContext())) {
        isStarted_ = false;
        throw core::SimulationFailure(environmentFailure(*error));
      }
      description_ = environment_->describe();
    }
    deliverFiles(plants);
    plants_ = std::move(plants);
    completedSteps_ = 0;
    pending_ = Pending{};
    isAnswered_ = false;
    isStarted_ = true;
    statistics_ = StepStatistics{};
    for (const derivation::PlantState& plant : plants_) {
      statistics_.modules += plant.string.size();
      statistics_.parameters += plant.string.parameterCount();
      statistics_.bytes += plant.string.bytes();
    }
  });
}

Outcome Simulation::Implementation::step() {
  return guarded([this] {
    answerPass();
    derivePass();
    deliverFiles(plants_);
    completeStep();
  });
}

Outcome Simulation::Implementation::answer() {
  return guarded([this] { answerPass(); });
}

namespace {

// by stop(n); a plant whose derivation length is reached goes on when it is asked to
bool hasStoppedItself(const derivation::PlantState& plant) {
  return plant.isStopped && plant.step < plant.derivationLength;
}

}  // namespace

void Simulation::Implementation::measureViewVolume() {
  if (!program_->usesViewVolume || program_->view.box) {
    return;
  }
  turtle::Scene scene;
  if (auto error = draw({.scene = &scene})) {
    throw core::SimulationFailure(std::move(*error));
  }
  const language::Box volume = turtle::boundsOf(scene, program_->view).value_or(language::Box{});
  for (derivation::PlantState& plant : plants_) {
    plant.viewVolume = volume;
  }
}

void Simulation::Implementation::derivePass() {
  // a file that cannot be written takes the derivation back as well
  const bool writesFiles = options_.fileWriter != nullptr && !program_->files.empty();
  const bool isKept = plants_.size() > 1 || writesFiles;
  measureViewVolume();
  bool hasDerived = false;
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    if (hasStoppedItself(plants_[plant])) {
      continue;
    }
    // a plant's failed derivation changes nothing of it; those before it are kept to be taken back
    if (isKept) {
      undo_[plant].underived = plants_[plant];
      undo_[plant].hasUnderived = true;
    }
    derivations_[plant].derive(plants_[plant]);
    hasDerived = true;
  }
  if (!hasDerived) {
    core::SimulationError error;
    error.code = core::SimulationErrorCode::Model;
    error.step = completedSteps_ + 1;
    error.message = "step " + std::to_string(error.step) +
                    ": the model has stopped itself, there is no further step. "
                    "Rewind the simulation to run it again.";
    throw core::SimulationFailure(std::move(error));
  }
}

void Simulation::Implementation::deliverFiles(std::vector<derivation::PlantState>& plants) {
  for (std::size_t plant = 0; plant < plants.size(); ++plant) {
    for (const derivation::FileOutput& output : derivation::takeOutput(plants[plant].files)) {
      const auto number = static_cast<std::uint32_t>(plant);
      const std::string name = derivation::fileNameOfPlant(program_->files[output.file].name, number);
      if (auto problem = options_.fileWriter->write(name, output.replaces, output.bytes)) {
        core::SimulationError error;
        error.code = core::SimulationErrorCode::Model;
        error.step = plants[plant].step;
        error.plant = number;
        error.message = "step " + std::to_string(error.step) + ", plant " + std::to_string(number) + ": " + *problem;
        throw core::SimulationFailure(std::move(error));
      }
    }
  }
}

void Simulation::Implementation::completeStep() {
  ++completedSteps_;
  isAnswered_ = false;
  pending_ = Pending{.replies = std::move(pending_.replies)};
  statistics_.step = completedSteps_;
  statistics_.modules = 0;
  statistics_.parameters = 0;
  statistics_.bytes = 0;
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    statistics_.modules += plants_[plant].string.size();
    statistics_.parameters += plants_[plant].string.parameterCount();
    statistics_.bytes += plants_[plant].string.bytes();
    undo_[plant].clear();
  }
}

void Simulation::Implementation::undoStep() {
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    undo_[plant].apply(plants_[plant]);
  }
  isAnswered_ = false;
}

core::SimulationError Simulation::Implementation::failed(core::SimulationError error) const {
  constexpr std::string_view kStays = "The simulation stays at step ";
  if (isStarted_ && error.message.find(kStays) == std::string::npos) {
    error.message += error.message.ends_with('.') ? " " : ". ";
    error.message += std::string(kStays) + std::to_string(completedSteps_) + ".";
  }
  return error;
}

std::uint64_t Simulation::Implementation::derivationLength() const {
  if (!plants_.empty()) {
    std::uint64_t length = 0;
    for (const derivation::PlantState& plant : plants_) {
      length = std::max(length, plant.derivationLength);
    }
    return length;
  }
  return options_.derivationLength.value_or(program_->derivationLength);
}

bool Simulation::Implementation::isFinished() const {
  return std::all_of(plants_.begin(), plants_.end(), [this](const derivation::PlantState& plant) {
    return plant.isStopped || completedSteps_ >= plant.derivationLength;
  });
}

Outcome Simulation::Implementation::draw(turtle::InterpretationOutput output) {
  output.fillsQueries = false;
  // its own derivations: a picture prints nothing and cannot be cancelled with a step
  while (displayDerivations_.size() < plants_.size()) {
    derivation::DerivationOptions options = derivationOptions(static_cast<std::uint32_t>(displayDerivations_.size()));
    options.cancelled = nullptr;
    if (options_.messages) {
      options.messages = [messages = options_.messages](core::MessageKind kind, std::string_view text) {
        if (kind == core::MessageKind::Warning) {
          messages(kind, text);
        }
      };
    }
    displayDerivations_.emplace_back(*program_, std::move(options));
  }
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    PlantVariables before;
    before.copyFrom(plants_[plant]);
    Outcome outcome;
    try {
      interpreter_.interpret(displayDerivations_[plant], plants_[plant], static_cast<std::uint32_t>(plant),
                             placements_[plant], output);
    } catch (const core::SimulationFailure& failure) {
      outcome = failed(failure.error());
    }
    // whatever the homomorphism's blocks did is taken back
    before.copyTo(plants_[plant]);
    if (outcome) {
      return outcome;
    }
  }
  return std::nullopt;
}

Simulation::Simulation(std::shared_ptr<const language::Program> program, std::vector<turtle::PlantPlacement> placements,
                       std::unique_ptr<turtle::EnvironmentProcess> environment, SimulationOptions options)
    : implementation_(std::make_unique<Implementation>(std::move(program), std::move(placements),
                                                       std::move(environment), std::move(options))) {}

Simulation::~Simulation() = default;

Outcome Simulation::rewind() {
  return implementation_->rewind();
}

Outcome Simulation::step() {
  return implementation_->step();
}

Outcome Simulation::answer() {
  return implementation_->answer();
}

bool Simulation::isFinished() const {
  return implementation_->isFinished();
}

bool Simulation::isAnswered() const {
  return implementation_->isAnswered_;
}

std::uint64_t Simulation::seed() const {
  return implementation_->seed_;
}

std::uint64_t Simulation::completedSteps() const {
  return implementation_->completedSteps_;
}

std::uint64_t Simulation::derivationLength() const {
  return implementation_->derivationLength();
}

std::size_t Simulation::plantCount() const {
  return implementation_->placements_.size();
}

const derivation::ModuleString& Simulation::string(std::size_t plant) const {
  ESPALIER_CHECK(plant < implementation_->plants_.size());
  return implementation_->plants_[plant].string;
}

const derivation::PlantState& Simulation::plantState(std::size_t plant) const {
  ESPALIER_CHECK(plant < implementation_->plants_.size());
  return implementation_->plants_[plant];
}

derivation::DerivationOptions Simulation::derivationOptions(std::size_t plant) const {
  return implementation_->derivationOptions(static_cast<std::uint32_t>(plant));
}

std::string Simulation::stringText(std::size_t plant) const {
  return derivation::toText(program(), string(plant), derivation::numberStyle(program().compatibility));
}

const StepStatistics& Simulation::statistics() const {
  return implementation_->statistics_;
}

const language::Program& Simulation::program() const {
  return *implementation_->program_;
}

std::shared_ptr<const language::Program> Simulation::sharedProgram() const {
  return implementation_->program_;
}

const SimulationOptions& Simulation::options() const {
  return implementation_->options_;
}

turtle::EnvironmentProcess* Simulation::environment() {
  return implementation_->environment_.get();
}

void Simulation::setCancelled(bool isCancelled) {
  implementation_->isCancelled_.store(isCancelled, std::memory_order_relaxed);
}

std::variant<turtle::Scene, core::SimulationError> Simulation::scene() const {
  turtle::Scene scene;
  if (auto error = implementation_->draw({.scene = &scene})) {
    return std::move(*error);
  }
  return scene;
}

std::variant<std::vector<turtle::TurtleRecord>, core::SimulationError> Simulation::turtleRecords() const {
  std::vector<turtle::TurtleRecord> records;
  if (auto error = implementation_->draw({.records = &records})) {
    return std::move(*error);
  }
  return records;
}

Outcome Simulation::visitModules(
    const std::function<void(const turtle::TurtleRecord&, std::uint64_t first)>& visit) const {
  return implementation_->draw({.onModule = visit});
}

std::uint64_t Simulation::stateHash() const {
  return implementation_->stateHash();
}

std::uint64_t Simulation::plantsHash() const {
  return implementation_->plantsHash();
}

void Simulation::save(core::ByteSink& sink) const {
  implementation_->save(sink);
}

Outcome Simulation::restore(std::string_view snapshot) {
  return implementation_->restore(snapshot);
}

}  // namespace espalier::simulation

#include "engine/simulation/simulation.h"

#include <algorithm>
#include <array>
#include <new>
#include <tuple>
#include <utility>

#include "engine/core/check.h"
#include "engine/derivation/expressions/model_files.h"
#include "engine/derivation/state/string_text.h"
#include "engine/simulation/simulation_implementation.h"
#include "engine/turtle/guarded_call.h"
#include "engine/turtle/interpretation/record_chain.h"

namespace espalier::simulation {

using Outcome = std::optional<core::SimulationError>;

Simulation::Implementation::Implementation(Programs programs, std::vector<PlantOrigin> plants,
                                           std::unique_ptr<turtle::EnvironmentProcess> environment,
                                           SimulationOptions options)
    : models_(std::move(programs)), environment_(std::move(environment)), options_(std::move(options)) {
  for (PlantOrigin& origin : plants) {
    ESPALIER_CHECK(origin.model < models_.size());
    members_.push_back({.origin = std::move(origin)});
  }
  if (environment_) {
    description_ = environment_->describe();
  }
  makeDerivations();
}

std::uint64_t Simulation::Implementation::effectiveSeed() const {
  return options_.hasSeed ? options_.seed : models_.modelSeed().value_or(options_.seed);
}

derivation::DerivationOptions Simulation::Implementation::derivationOptions(std::uint32_t plant,
                                                                            const Plant& member) const {
  derivation::DerivationOptions options;
  options.seed = seed_;
  // of several models one names the seed of all
  options.hasSeed = options_.hasSeed || models_.size() > 1;
  options.plant = plant;
  options.derivationLength = derivationLengthOf(member);
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
  for (std::uint32_t plant = 0; plant < members_.size(); ++plant) {
    derivations_.push_back(members_[plant].isAlive() ? makeDerivation(plant, members_[plant]) : nullptr);
  }
  undo_.resize(members_.size());
}

turtle::EnvironmentContext Simulation::Implementation::environmentContext() const {
  turtle::EnvironmentContext context;
  context.simulation = options_.name;
  context.plantCount = static_cast<std::uint32_t>(members_.size());
  context.symbols = models_.symbolNames();
  context.seed = seed_;
  context.world = options_.world;
  return context;
}

void Simulation::Implementation::startPlant(std::size_t plant, derivation::PlantState& state) const {
  if (options_.startString.empty()) {
    derivations_[plant]->rewind(state);
    return;
  }
  auto read = derivation::parseText(programOf(plant), options_.startString);
  if (const std::string* problem = std::get_if<std::string>(&read)) {
    core::SimulationError error;
    error.code = core::SimulationErrorCode::Model;
    error.message = "the string to start from, " + *problem + ".";
    throw core::SimulationFailure(std::move(error));
  }
  derivations_[plant]->rewind(state, &std::get<derivation::ModuleString>(read));
}

Outcome Simulation::Implementation::rewind() {
  return guarded([this] {
    undoStep();
    // those that came during a run are not there yet, those that went are there again
    std::vector<Plant> members = founders();
    const bool isOther = members.size() != members_.size() || livingPlantCount() != members_.size();
    members_.swap(members);
    try {
      if (isOther) {
        makeDerivations();
      }
      begin();
    } catch (...) {
      members_.swap(members);
      if (isOther) {
        makeDerivations();
      }
      throw;
    }
  });
}

void Simulation::Implementation::begin() {
  // the plants first: a failing Start changes nothing
  std::vector<derivation::PlantState> plants(members_.size());
  for (std::size_t plant = 0; plant < plants.size(); ++plant) {
    startPlant(plant, plants[plant]);
  }
  if (environment_) {
    const auto open = [&] { return environment_->open(environmentContext()); };
    if (const auto error = turtle::guardedCall(environment_->describe().name, open)) {
      isStarted_ = false;
      throw core::SimulationFailure(environmentFailure(*error));
    }
    description_ = environment_->describe();
  }
  for (std::size_t plant = 0; plant < plants.size(); ++plant) {
    deliverFiles(plant, programOf(plant), plants[plant]);
  }
  plants_ = std::move(plants);
  completedSteps_ = 0;
  pending_ = Pending{};
  isAnswered_ = false;
  isStarted_ = true;
  statistics_ = StepStatistics{};
  countStrings();
}

Outcome Simulation::Implementation::step() {
  return guarded([this] {
    answerPass();
    derivePass();
    growSeedlings();
    deliverAllFiles();
    completeStep();
  });
}

Outcome Simulation::Implementation::answer() {
  return guarded([this] { answerPass(); });
}

void Simulation::Implementation::deliverFiles(std::size_t plant, const language::Program& program,
                                              derivation::PlantState& state) {
  for (const derivation::FileOutput& output : derivation::takeOutput(state.files)) {
    const auto number = static_cast<std::uint32_t>(plant);
    const std::string name = derivation::fileNameOfPlant(program.files[output.file].name, number);
    if (auto problem = options_.fileWriter->write(name, output.replaces, output.bytes)) {
      core::SimulationError error;
      error.code = core::SimulationErrorCode::Model;
      error.step = state.step;
      error.plant = number;
      error.message = "step " + std::to_string(error.step) + ", plant " + std::to_string(number) + ": " + *problem;
      throw core::SimulationFailure(std::move(error));
    }
  }
}

void Simulation::Implementation::deliverAllFiles() {
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    deliverFiles(plant, programOf(plant), plants_[plant]);
  }
  for (std::size_t i = 0; i < seedlings_.size(); ++i) {
    Seedling& seedling = seedlings_[i];
    deliverFiles(plants_.size() + i, *models_.programs()[seedling.member.origin.model], seedling.state);
  }
}

void Simulation::Implementation::countStrings() {
  statistics_.step = completedSteps_;
  statistics_.modules = 0;
  statistics_.parameters = 0;
  statistics_.bytes = 0;
  statistics_.plants = livingPlantCount();
  for (const derivation::PlantState& plant : plants_) {
    statistics_.modules += plant.string.size();
    statistics_.parameters += plant.string.parameterCount();
    statistics_.bytes += plant.string.bytes();
  }
}

void Simulation::Implementation::completeStep() {
  ++completedSteps_;
  isAnswered_ = false;
  pending_ = Pending{.replies = std::move(pending_.replies)};
  for (StepUndo& undo : undo_) {
    undo.clear();
  }
  endAndBegin();
  countStrings();
}

void Simulation::Implementation::undoStep() {
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    undo_[plant].apply(plants_[plant]);
  }
  forgetLife();
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

std::uint64_t Simulation::Implementation::runLength() const {
  return options_.derivationLength.value_or(models_.longestDerivation());
}

std::optional<std::uint64_t> Simulation::Implementation::derivationLengthOf(const Plant& member) const {
  // alone a model knows its own length; in company all end with the run
  if (models_.size() == 1 && member.birthStep == 0) {
    return options_.derivationLength;
  }
  return std::max(runLength(), member.birthStep) - member.birthStep;
}

std::uint64_t Simulation::Implementation::derivationLength() const {
  if (plants_.empty()) {
    return runLength();
  }
  std::uint64_t length = 0;
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    length = std::max(length, members_[plant].birthStep + plants_[plant].derivationLength);
  }
  return length;
}

bool Simulation::Implementation::isFinished() const {
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    const derivation::PlantState& state = plants_[plant];
    if (members_[plant].isAlive() && !state.isStopped &&
        completedSteps_ < members_[plant].birthStep + state.derivationLength) {
      return false;
    }
  }
  return true;
}

namespace {

std::vector<PlantOrigin> ofOneModel(std::vector<turtle::PlantPlacement> placements) {
  std::vector<PlantOrigin> origins;
  for (const turtle::PlantPlacement& placement : placements) {
    origins.emplace_back().placement = placement;
  }
  return origins;
}

// the order in which plants are numbered
std::vector<PlantOrigin> inOrder(std::vector<PlantOrigin> origins) {
  const auto rank = [](const PlantOrigin& origin) {
    const auto [position, frame] = origin.placement;
    const auto part = [](const core::Vec3& v) { return std::array{v.x, v.y, v.z}; };
    return std::tuple(part(position), part(frame.heading), part(frame.left), part(frame.up), origin.model,
                      origin.colourShift, origin.name);
  };
  std::sort(origins.begin(), origins.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  return origins;
}

}  // namespace

Simulation::Simulation(std::shared_ptr<const language::Program> program, std::vector<turtle::PlantPlacement> placements,
                       std::unique_ptr<turtle::EnvironmentProcess> environment, SimulationOptions options)
    : implementation_(std::make_unique<Implementation>(std::vector{std::move(program)},
                                                       ofOneModel(std::move(placements)), std::move(environment),
                                                       std::move(options))) {}

Simulation::Simulation(Programs programs, std::vector<PlantOrigin> plants,
                       std::unique_ptr<turtle::EnvironmentProcess> environment, SimulationOptions options)
    : implementation_(std::make_unique<Implementation>(std::move(programs), inOrder(std::move(plants)),
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
  return implementation_->members_.size();
}

std::uint64_t Simulation::livingPlantCount() const {
  return implementation_->livingPlantCount();
}

const Plant& Simulation::plant(std::size_t plant) const {
  ESPALIER_CHECK(plant < implementation_->members_.size());
  return implementation_->members_[plant];
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
  ESPALIER_CHECK(plant < implementation_->members_.size());
  return implementation_->derivationOptions(static_cast<std::uint32_t>(plant), implementation_->members_[plant]);
}

std::string Simulation::stringText(std::size_t plant) const {
  const language::Program& own = program(plant);
  return derivation::toText(own, string(plant), derivation::numberStyle(own.compatibility));
}

const StepStatistics& Simulation::statistics() const {
  return implementation_->statistics_;
}

const language::Program& Simulation::program(std::size_t plant) const {
  if (implementation_->members_.empty()) {
    return implementation_->models_.first();
  }
  ESPALIER_CHECK(plant < implementation_->members_.size());
  return implementation_->programOf(plant);
}

const Programs& Simulation::programs() const {
  return implementation_->models_.programs();
}

const std::vector<std::string>& Simulation::symbolNames() const {
  return implementation_->models_.symbolNames();
}

const files::ViewSettings& Simulation::view() const {
  return implementation_->models_.view();
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

std::variant<std::shared_ptr<const turtle::RecordChain>, core::SimulationError> Simulation::recordChain(
    const turtle::RecordChain* base) const {
  const Programs& programs = implementation_->models_.programs();
  if (!std::all_of(programs.begin(), programs.end(), [](const auto& it) { return turtle::isRepeatable(*it); })) {
    return nullptr;
  }
  auto chain = std::make_shared<turtle::RecordChain>();
  if (auto error = implementation_->chainRecords(base, *chain)) {
    return std::move(*error);
  }
  return chain;
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

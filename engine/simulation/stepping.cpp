#include <algorithm>
#include <new>
#include <utility>

#include "engine/core/check.h"
#include "engine/derivation/expressions/model_files.h"
#include "engine/derivation/state/string_text.h"
#include "engine/simulation/plants/plant_variables.h"
#include "engine/simulation/simulation_implementation.h"
#include "engine/turtle/scene/scene_bounds.h"

namespace espalier::simulation {
namespace {

std::vector<Plant> membersOf(std::vector<PlantOrigin> plants, std::size_t modelCount) {
  std::vector<Plant> members;
  for (PlantOrigin& origin : plants) {
    ESPALIER_CHECK(origin.model < modelCount);
    members.push_back({.origin = std::move(origin)});
  }
  return members;
}

// by stop(n); a plant whose derivation length is reached goes on when it is asked to
bool hasStoppedItself(const derivation::PlantState& plant) {
  return plant.isStopped && plant.step < plant.derivationLength;
}

[[noreturn]] void failAsModel(std::string message, std::uint64_t step = 0, std::uint32_t plant = 0) {
  core::SimulationError error;
  error.code = core::SimulationErrorCode::Model;
  error.step = step;
  error.plant = plant;
  error.message = std::move(message);
  throw core::SimulationFailure(std::move(error));
}

}  // namespace

Simulation::Implementation::Implementation(Programs programs, std::vector<PlantOrigin> plants,
                                           std::unique_ptr<turtle::EnvironmentProcess> environment,
                                           SimulationOptions options)
    : models_(std::move(programs)),
      options_(std::move(options)),
      messages_(options_.messages),
      derivations_(models_, options_, isCancelled_, messages_),
      population_(models_, derivations_, membersOf(std::move(plants), models_.size())),
      transaction_(population_.size()),
      environment_(std::move(environment)),
      drawing_(models_, options_, derivations_),
      worldVariables_(models_.programs()),
      answerPass_(AnswerPass::Parts{.models = models_,
                                    .options = options_,
                                    .derivations = derivations_,
                                    .population = population_,
                                    .transaction = transaction_,
                                    .changes = changes_,
                                    .births = births_,
                                    .environment = environment_,
                                    .drawing = drawing_,
                                    .statistics = statistics_}),
      derivationPass_(options_, messages_, population_, transaction_, productions_, ages_) {}

// A step. Each part before the completion can fail: undoStep then takes the step back. Only replies that have arrived
// from the environment are kept for the next try.
Simulation::Implementation::Outcome Simulation::Implementation::step() {
  return guarded([this] {
    // interpret the strings, put the queries to the environment, write the replies into the strings
    answerQueries();
    // advance every plant that does not end in this step
    derivePlants();
    // start a plant for each seed that took root
    births_.growSeedlings(population_, derivations_, completedSteps_);
    // deliver the output of the models to their files
    deliverAllFiles();
    // count the step, forget how to take it back, let plants end and seedlings become plants
    completeStep();
  });
}

Simulation::Implementation::Outcome Simulation::Implementation::answer() {
  return guarded([this] { answerQueries(); });
}

template <typename Part>
Simulation::Implementation::Outcome Simulation::Implementation::guarded(Part&& part) {
  try {
    part();
    return std::nullopt;
  } catch (const core::SimulationFailure& failure) {
    undoStep();
    return failed(failure.error());
  } catch (const std::bad_alloc&) {
    undoStep();
    core::SimulationError error;
    error.code = core::SimulationErrorCode::LimitExceeded;
    error.step = completedSteps_ + 1;
    error.message = "step " + std::to_string(error.step) + ": there is not enough memory.";
    return failed(std::move(error));
  }
}

void Simulation::Implementation::answerQueries() {
  if (!isStarted_) {
    failAsModel("The simulation has not been started. Rewind it or restore a snapshot first.");
  }
  // answer() may have made the pass already
  if (!transaction_.isAnswered()) {
    if (const auto problem = worldVariables_.problem(options_.world, completedSteps_)) {
      failAsModel("step " + std::to_string(completedSteps_ + 1) + ": " + *problem, completedSteps_ + 1);
    }
    answerPass_.run(completedSteps_);
    transaction_.setAnswered();
    if (changes_.isFollowed()) {
      transaction_.noteAnswers(population_.states());
      noteAnswers();
    }
  }
}

void Simulation::Implementation::derivePlants() {
  measureViewVolume();
  std::vector<std::size_t> growing;
  const std::vector<derivation::PlantState>& states = population_.states();
  for (std::size_t plant = 0; plant < states.size(); ++plant) {
    if (population_.member(plant).isAlive() && !births_.isDying(plant) && !hasStoppedItself(states[plant])) {
      growing.push_back(plant);
    }
  }
  // something after a plant's derivation can fail: another plant, a seedling, a file
  const bool writesFiles = options_.fileWriter != nullptr && models_.writesFiles();
  derivationPass_.run(growing, states.size() > 1 || writesFiles || births_.hasSeeds(), changes_.isFollowed(),
                      completedSteps_);
  if (growing.empty() && !births_.hasDeaths()) {
    failAsModel("step " + std::to_string(completedSteps_ + 1) +
                    (population_.livingCount() == 0 ? ": no plant is alive" : ": the model has stopped itself") +
                    ", there is no further step. Rewind the simulation to run it again.",
                completedSteps_ + 1);
  }
}

void Simulation::Implementation::measureViewVolume() {
  // a model with a box of its own has it from the start
  const auto& programs = models_.programs();
  if (std::none_of(programs.begin(), programs.end(),
                   [](const auto& program) { return program->usesViewVolume && !program->view.box; })) {
    return;
  }
  turtle::Scene scene;
  drawing_.draw(population_.members(), population_.states(), {.scene = &scene});
  const files::Box volume = turtle::boundsOf(scene, models_.view()).value_or(files::Box{});
  for (derivation::PlantState& plant : population_.states()) {
    plant.viewVolume = volume;
  }
}

void Simulation::Implementation::deliverAllFiles() {
  std::vector<derivation::PlantState>& states = population_.states();
  for (std::size_t plant = 0; plant < states.size(); ++plant) {
    deliverFiles(plant, population_.program(plant), states[plant]);
  }
  std::size_t number = states.size();
  for (BirthsAndDeaths::Seedling& seedling : births_.seedlings()) {
    deliverFiles(number++, *models_.programs()[seedling.member.origin.model], seedling.state);
  }
}

void Simulation::Implementation::deliverFiles(std::size_t plant, const language::Program& program,
                                              derivation::PlantState& state) {
  for (const derivation::FileOutput& output : derivation::takeOutput(state.files)) {
    const auto number = static_cast<std::uint32_t>(plant);
    const std::string name = derivation::fileNameOfPlant(program.files[output.file].name, number);
    if (auto problem = options_.fileWriter->write(name, output.replaces, output.bytes)) {
      failAsModel("step " + std::to_string(state.step) + ", plant " + std::to_string(number) + ": " + *problem,
                  state.step, number);
    }
  }
}

void Simulation::Implementation::completeStep() {
  ++completedSteps_;
  for (std::size_t plant = 0; changes_.isFollowed() && plant < population_.size(); ++plant) {
    if (const derivation::StepChanges* const derived = transaction_.derived(plant)) {
      changes_.add(plant, *derived);
    }
  }
  if (productions_.isFollowed()) {
    productions_.complete(completedSteps_);
  }
  transaction_.commit();
  births_.complete(population_, transaction_, completedSteps_, statistics_);
  if (ages_.isFollowed()) {
    ages_.complete(population_.states(), completedSteps_);
  }
  worldVariables_.set(population_, options_.world, completedSteps_);
  countStrings();
}

void Simulation::Implementation::noteAnswers() {
  for (std::size_t plant = 0; plant < population_.states().size(); ++plant) {
    if (const derivation::StepChanges* const answered = transaction_.answered(plant)) {
      changes_.add(plant, *answered);
    }
  }
}

void Simulation::Implementation::undoStep() {
  // the answers go as they came
  if (transaction_.hasNotedAnswers()) {
    noteAnswers();
  } else if (transaction_.isAnswered()) {
    changes_.forget();
  }
  // the pass may have ended half-way
  changes_.forget(ChangeReader::Queries);
  transaction_.takeBack(population_.states());
  births_.clear();
}

core::SimulationError Simulation::Implementation::failed(core::SimulationError error) const {
  return isStarted_ ? sayingWhereItStays(std::move(error), completedSteps_) : error;
}

void Simulation::Implementation::countStrings() {
  const Population::Totals totals = population_.totals();
  statistics_.step = completedSteps_;
  statistics_.modules = totals.modules;
  statistics_.parameters = totals.parameters;
  statistics_.bytes = totals.bytes;
  statistics_.plants = population_.livingCount();
}

Simulation::Implementation::Outcome Simulation::Implementation::rewind() {
  return guarded([this] {
    undoStep();
    // plants that came during a run are not there yet, plants that went are there again
    std::vector<Plant> founders = population_.founders();
    if (founders.size() == population_.size() && population_.livingCount() == founders.size()) {
      begin();
      return;
    }
    Population before = std::exchange(population_, Population(models_, derivations_, std::move(founders)));
    transaction_.setPlantCount(population_.size());
    try {
      begin();
    } catch (...) {
      population_ = std::move(before);
      transaction_.setPlantCount(population_.size());
      throw;
    }
  });
}

Simulation::Implementation::Outcome Simulation::Implementation::rewind(std::uint64_t seed) {
  const bool hadSeed = std::exchange(options_.hasSeed, true);
  const std::uint64_t before = std::exchange(options_.seed, seed);
  population_.reseed();
  viewOptions_ = nullptr;
  Outcome failure = rewind();
  if (failure) {
    options_.hasSeed = hadSeed;
    options_.seed = before;
    population_.reseed();
  }
  return failure;
}

void Simulation::Implementation::begin() {
  // the plants first: a failing Start changes nothing
  std::vector<derivation::PlantState> plants(population_.size());
  for (std::size_t plant = 0; plant < plants.size(); ++plant) {
    startPlant(plant, plants[plant]);
  }
  if (environment_.exists()) {
    if (const auto error = environment_.open(environmentContext())) {
      isStarted_ = false;
      throw core::SimulationFailure(environmentFailure(*error, 0));
    }
    environment_.readDescription();
  }
  for (std::size_t plant = 0; plant < plants.size(); ++plant) {
    deliverFiles(plant, population_.program(plant), plants[plant]);
  }
  changes_.forget();
  answerPass_.forgetWarnings();
  population_.setStates(std::move(plants));
  worldVariables_.set(population_, options_.world, 0);
  transaction_ = StepTransaction(population_.size());
  completedSteps_ = 0;
  productions_.goTo(0);
  ages_.goTo(population_.states(), 0);
  isStarted_ = true;
  statistics_ = StepStatistics{};
  countStrings();
}

void Simulation::Implementation::startPlant(std::size_t plant, derivation::PlantState& state) const {
  if (options_.startString.empty()) {
    population_.derivation(plant).rewind(state);
    return;
  }
  auto read = derivation::parseText(population_.program(plant), options_.startString);
  if (!read) {
    failAsModel("the string to start from, " + read.error() + ".");
  }
  population_.derivation(plant).rewind(state, &*read);
}

turtle::EnvironmentContext Simulation::Implementation::environmentContext() const {
  turtle::EnvironmentContext context;
  context.simulation = options_.name;
  context.plantCount = static_cast<std::uint32_t>(population_.size());
  context.symbols = models_.symbolNames();
  context.seed = derivations_.seed();
  context.world = options_.world;
  return context;
}

Simulation::Implementation::Outcome Simulation::Implementation::draw(turtle::InterpretationOutput output) {
  try {
    drawing_.draw(population_.members(), population_.states(), std::move(output));
    return std::nullopt;
  } catch (const core::SimulationFailure& failure) {
    return failed(failure.error());
  }
}

std::shared_ptr<const PlantsView> Simulation::Implementation::takeView() {
  auto view = std::make_shared<PlantsView>();
  if (viewOptions_ == nullptr) {
    viewOptions_ = std::make_shared<const SimulationOptions>(options_);
  }
  view->base = changes_.isKnown(ChangeReader::Views) ? viewNumber_ : 0;
  view->number = ++viewNumber_;
  view->options = viewOptions_;
  view->programs = models_.programs();
  view->members = population_.sharedMembers();
  view->plants.reserve(population_.size());
  for (derivation::PlantState& state : population_.states()) {
    view->plants.push_back(sharedState(state));
  }
  view->changes = changes_.take(ChangeReader::Views, population_.states());
  view->statistics = statistics_;
  view->completedSteps = completedSteps_;
  view->isFinished = population_.isFinished(completedSteps_);
  return view;
}

}  // namespace espalier::simulation

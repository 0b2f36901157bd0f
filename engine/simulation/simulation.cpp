#include "engine/simulation/simulation.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "engine/core/check.h"
#include "engine/derivation/state/string_text.h"
#include "engine/simulation/simulation_implementation.h"

namespace espalier::simulation {

using Outcome = std::optional<core::SimulationError>;

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

Outcome Simulation::rewind(std::uint64_t seed) {
  return implementation_->rewind(seed);
}

Outcome Simulation::step() {
  return implementation_->step();
}

Outcome Simulation::answer() {
  return implementation_->answer();
}

bool Simulation::isFinished() const {
  return implementation_->population().isFinished(implementation_->completedSteps());
}

bool Simulation::isAnswered() const {
  return implementation_->transaction().isAnswered();
}

std::uint64_t Simulation::seed() const {
  return implementation_->derivations().seed();
}

std::uint64_t Simulation::completedSteps() const {
  return implementation_->completedSteps();
}

std::uint64_t Simulation::derivationLength() const {
  return implementation_->population().derivationLength();
}

std::size_t Simulation::plantCount() const {
  return implementation_->population().size();
}

std::uint64_t Simulation::livingPlantCount() const {
  return implementation_->population().livingCount();
}

const Plant& Simulation::plant(std::size_t plant) const {
  ESPALIER_CHECK(plant < implementation_->population().size());
  return implementation_->population().member(plant);
}

const derivation::ModuleString& Simulation::string(std::size_t plant) const {
  return plantState(plant).string;
}

const derivation::PlantState& Simulation::plantState(std::size_t plant) const {
  ESPALIER_CHECK(plant < implementation_->population().states().size());
  return implementation_->population().states()[plant];
}

derivation::DerivationOptions Simulation::derivationOptions(std::size_t plant) const {
  return implementation_->derivations().options(static_cast<std::uint32_t>(plant), this->plant(plant));
}

std::string Simulation::stringText(std::size_t plant) const {
  const language::Program& own = program(plant);
  return derivation::toText(own, string(plant), derivation::numberStyle(own.compatibility));
}

const StepStatistics& Simulation::statistics() const {
  return implementation_->statistics();
}

const language::Program& Simulation::program(std::size_t plant) const {
  const Population& population = implementation_->population();
  if (population.size() == 0) {
    return implementation_->models().first();
  }
  ESPALIER_CHECK(plant < population.size());
  return population.program(plant);
}

const Programs& Simulation::programs() const {
  return implementation_->models().programs();
}

const std::vector<std::string>& Simulation::symbolNames() const {
  return implementation_->models().symbolNames();
}

const files::ViewSettings& Simulation::view() const {
  return implementation_->models().view();
}

const SimulationOptions& Simulation::options() const {
  return implementation_->options();
}

std::uint64_t Simulation::keptBytes() const {
  return implementation_->keptBytes();
}

turtle::EnvironmentProcess* Simulation::environment() {
  return implementation_->environment().process();
}

void Simulation::setCancelled(bool isCancelled) {
  implementation_->setCancelled(isCancelled);
}

tl::expected<turtle::Scene, core::SimulationError> Simulation::scene() const {
  turtle::Scene scene;
  if (auto error = implementation_->draw({.scene = &scene})) {
    return tl::unexpected(std::move(*error));
  }
  return scene;
}

tl::expected<std::vector<turtle::TurtleRecord>, core::SimulationError> Simulation::turtleRecords() const {
  std::vector<turtle::TurtleRecord> records;
  if (auto error = implementation_->draw({.records = &records})) {
    return tl::unexpected(std::move(*error));
  }
  return records;
}

std::shared_ptr<const PlantsView> Simulation::takeView() {
  return implementation_->takeView();
}

void Simulation::followChanges(bool isWanted) {
  implementation_->followChanges(isWanted);
}
void Simulation::countProductions(bool isWanted) {
  implementation_->countProductions(isWanted);
}
std::shared_ptr<const ProductionUses> Simulation::productionUses() const {
  return implementation_->productionUses();
}
void Simulation::followAges(bool isWanted) {
  implementation_->followAges(isWanted);
}
std::span<const std::uint64_t> Simulation::moduleBirths(std::size_t plant) const {
  return implementation_->ages().births(plant);
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

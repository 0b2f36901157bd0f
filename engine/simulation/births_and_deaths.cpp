#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/simulation/simulation_implementation.h"
#include "engine/turtle/query_batches.h"

namespace espalier::simulation {

std::uint64_t Simulation::Implementation::livingPlantCount() const {
  return static_cast<std::uint64_t>(
      std::count_if(members_.begin(), members_.end(), [](const Plant& member) { return member.isAlive(); }));
}

bool Simulation::Implementation::isGrowing(std::size_t plant) const {
  return members_[plant].isAlive() && !std::binary_search(dying_.begin(), dying_.end(), plant);
}

std::vector<Plant> Simulation::Implementation::founders() const {
  std::vector<Plant> founders;
  for (const Plant& member : members_) {
    if (member.birthStep == 0) {
      founders.push_back({.origin = member.origin});
    }
  }
  return founders;
}

std::uint32_t Simulation::Implementation::modelOfSeed(std::size_t query) const {
  const auto parameters = queries_.parametersOf(query);
  const std::uint32_t mother = queries_.plant[query];
  const double number = parameters.size() < 2 ? 0.0 : parameters[1];
  if (number == 0.0) {
    return members_[mother].origin.model;
  }
  if (number >= 1.0 && number <= static_cast<double>(models_.size()) && number == std::floor(number)) {
    return static_cast<std::uint32_t>(number) - 1;
  }
  core::SimulationError error;
  error.code = core::SimulationErrorCode::Model;
  error.step = completedSteps_ + 1;
  error.plant = mother;
  error.module = queries_.module[query];
  error.message = "step " + std::to_string(error.step) + ", plant " + std::to_string(mother) + ", module " +
                  std::to_string(*error.module) + " ('Seed'): there is no model ";
  core::appendNumber(error.message, number, core::NumberStyle::Shortest);
  error.message += ". Parameter 2 is the number of a model, 1 to " + std::to_string(models_.size()) +
                   " in the order in which they are listed, or 0 for the plant's own.";
  throw core::SimulationFailure(std::move(error));
}

void Simulation::Implementation::takeLifeQueries() {
  // the simulation's own queries are taken out of the batch; the environment sees the rest
  std::vector<std::size_t> others;
  others.reserve(queries_.size());
  for (std::size_t query = 0; query < queries_.size(); ++query) {
    const core::SymbolId symbol = queries_.symbol[query];
    if (!models_.isSeed(symbol) && !models_.isDeath(symbol)) {
      others.push_back(query);
      continue;
    }
    const auto parameters = queries_.parametersOf(query);
    const std::uint32_t plant = queries_.plant[query];
    if (models_.isDeath(symbol)) {
      if (parameters.empty() || parameters[0] != 0.0) {
        dying_.push_back(plant);
      }
    } else if (parameters.empty() || parameters[0] > 0.0) {
      seeds_.push_back({.mother = plant,
                        .module = queries_.module[query],
                        .offset = parameters.empty() ? turtle::kTransientQuery : queryOffsets_[query],
                        .model = modelOfSeed(query),
                        .position = queries_.position[query]});
    }
  }
  // plants come one after the other, so that the dying are in order
  dying_.erase(std::unique(dying_.begin(), dying_.end()), dying_.end());
  if (others.size() < queries_.size()) {
    std::vector<std::uint64_t> offsets;
    offsets.reserve(others.size());
    for (const std::size_t query : others) {
      offsets.push_back(queryOffsets_[query]);
    }
    turtle::QueryBatch rest;
    turtle::selectQueries(queries_, others, 0, rest);
    queries_ = std::move(rest);
    queryOffsets_ = std::move(offsets);
  }
  if (seeds_.empty()) {
    return;
  }
  std::vector<core::Vec3> places;
  for (const Plant& member : members_) {
    if (member.isAlive()) {
      places.push_back(member.origin.placement.position);
    }
  }
  settleSeeds(seeds_, places, options_.seeds, options_.world.up, seed_, completedSteps_);
}

void Simulation::Implementation::writeLifeReplies() {
  for (const Seed& seed : seeds_) {
    if (seed.offset != turtle::kTransientQuery) {
      writeReply(seed.mother, seed.offset, seed.hasTakenRoot ? 0.0 : -1.0);
      ++statistics_.answers;
    }
  }
}

void Simulation::Implementation::growSeedlings() {
  for (const Seed& seed : seeds_) {
    if (!seed.hasTakenRoot) {
      continue;
    }
    const PlantOrigin& mother = members_[seed.mother].origin;
    const auto number = static_cast<std::uint32_t>(members_.size() + seedlings_.size());
    Seedling seedling;
    seedling.member.origin.model = seed.model;
    seedling.member.origin.placement = {seed.position, mother.placement.frame};
    seedling.member.origin.colourShift = seed.model == mother.model ? mother.colourShift : 0;
    seedling.member.birthStep = completedSteps_ + 1;
    seedling.derivation = makeDerivation(number, seedling.member);
    seedling.derivation->rewind(seedling.state);
    seedlings_.push_back(std::move(seedling));
  }
}

void Simulation::Implementation::endAndBegin() {
  statistics_.births = seedlings_.size();
  statistics_.deaths = dying_.size();
  for (const std::uint32_t plant : dying_) {
    members_[plant].deathStep = completedSteps_;
    derivation::PlantState rest;
    rest.step = plants_[plant].step;
    rest.derivationLength = plants_[plant].derivationLength;
    plants_[plant] = std::move(rest);
    derivations_[plant].reset();
    undo_[plant] = StepUndo();
    if (plant < displayDerivations_.size()) {
      displayDerivations_[plant].reset();
    }
  }
  for (Seedling& seedling : seedlings_) {
    members_.push_back(std::move(seedling.member));
    plants_.push_back(std::move(seedling.state));
    derivations_.push_back(std::move(seedling.derivation));
  }
  undo_.resize(members_.size());
  forgetLife();
}

void Simulation::Implementation::forgetLife() {
  seeds_.clear();
  dying_.clear();
  seedlings_.clear();
}

}  // namespace espalier::simulation

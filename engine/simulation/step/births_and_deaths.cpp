#include "engine/simulation/step/births_and_deaths.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/turtle/query_batches.h"

namespace espalier::simulation {
namespace {

/// The model of a seed: parameter 2 of its query, 0 or left out for the mother's own.
std::uint32_t modelOfSeed(const turtle::QueryBatch& queries, std::size_t query, const Population& population,
                          const ModelSet& models, std::uint64_t completedSteps) {
  const auto parameters = queries.parametersOf(query);
  const std::uint32_t mother = queries.plant[query];
  const double number = parameters.size() < 2 ? 0.0 : parameters[1];
  if (number == 0.0) {
    return population.member(mother).origin.model;
  }
  if (number >= 1.0 && number <= static_cast<double>(models.size()) && number == std::floor(number)) {
    return static_cast<std::uint32_t>(number) - 1;
  }
  core::SimulationError error;
  error.code = core::SimulationErrorCode::Model;
  error.step = completedSteps + 1;
  error.plant = mother;
  error.module = queries.module[query];
  error.message = "step " + std::to_string(error.step) + ", plant " + std::to_string(mother) + ", module " +
                  std::to_string(*error.module) + " ('Seed'): there is no model ";
  core::appendNumber(error.message, number, core::NumberStyle::Shortest);
  error.message += ". Parameter 2 is the number of a model, 1 to " + std::to_string(models.size()) +
                   " in the order in which they are listed, or 0 for the plant's own.";
  throw core::SimulationFailure(std::move(error));
}

/// Reduces the batch and its offsets to these queries.
void keepOnly(const std::vector<std::size_t>& chosen, turtle::QueryBatch& queries,
              std::vector<std::uint64_t>& offsets) {
  std::vector<std::uint64_t> chosenOffsets;
  chosenOffsets.reserve(chosen.size());
  for (const std::size_t query : chosen) {
    chosenOffsets.push_back(offsets[query]);
  }
  turtle::QueryBatch rest;
  turtle::selectQueries(queries, chosen, 0, rest);
  queries = std::move(rest);
  offsets = std::move(chosenOffsets);
}

}  // namespace

void BirthsAndDeaths::takeQueries(const ModelSet& models, const Population& population,
                                  const SimulationOptions& options, std::uint64_t runSeed, std::uint64_t completedSteps,
                                  turtle::QueryBatch& queries, std::vector<std::uint64_t>& offsets) {
  std::vector<std::size_t> others;
  others.reserve(queries.size());
  for (std::size_t query = 0; query < queries.size(); ++query) {
    const core::SymbolId symbol = queries.symbol[query];
    if (!models.isSeed(symbol) && !models.isDeath(symbol)) {
      others.push_back(query);
      continue;
    }
    const auto parameters = queries.parametersOf(query);
    const std::uint32_t plant = queries.plant[query];
    if (models.isDeath(symbol)) {
      if (parameters.empty() || parameters[0] != 0.0) {
        dying_.push_back(plant);
      }
    } else if (parameters.empty() || parameters[0] > 0.0) {
      seeds_.push_back({.mother = plant,
                        .module = queries.module[query],
                        .offset = parameters.empty() ? turtle::kTransientQuery : offsets[query],
                        .model = modelOfSeed(queries, query, population, models, completedSteps),
                        .position = queries.position[query]});
    }
  }
  // plants come one after the other, so that the dying are in order
  dying_.erase(std::unique(dying_.begin(), dying_.end()), dying_.end());
  if (others.size() < queries.size()) {
    keepOnly(others, queries, offsets);
  }
  if (!seeds_.empty()) {
    settleSeeds(seeds_, population.places(), options.seeds, options.world.up, runSeed, completedSteps);
  }
}

std::uint64_t BirthsAndDeaths::writeReplies(std::vector<derivation::PlantState>& states,
                                            StepTransaction& transaction) const {
  std::uint64_t answers = 0;
  for (const Seed& seed : seeds_) {
    if (seed.offset != turtle::kTransientQuery) {
      transaction.write(seed.mother, states[seed.mother], seed.module, seed.offset, seed.hasTakenRoot ? 0.0 : -1.0);
      ++answers;
    }
  }
  return answers;
}

bool BirthsAndDeaths::isDying(std::size_t plant) const {
  return std::binary_search(dying_.begin(), dying_.end(), plant);
}

void BirthsAndDeaths::growSeedlings(const Population& population, const DerivationFactory& factory,
                                    std::uint64_t completedSteps) {
  for (const Seed& seed : seeds_) {
    if (!seed.hasTakenRoot) {
      continue;
    }
    const PlantOrigin& mother = population.member(seed.mother).origin;
    const auto number = static_cast<std::uint32_t>(population.size() + seedlings_.size());
    Seedling seedling;
    seedling.member.origin.model = seed.model;
    seedling.member.origin.placement = {seed.position, mother.placement.frame};
    seedling.member.origin.colourShift = seed.model == mother.model ? mother.colourShift : 0;
    seedling.member.birthStep = completedSteps + 1;
    seedling.derivation = factory.forSteps(number, seedling.member);
    seedling.derivation->rewind(seedling.state);
    seedlings_.push_back(std::move(seedling));
  }
}

void BirthsAndDeaths::complete(Population& population, StepTransaction& transaction, std::uint64_t completedSteps,
                               StepStatistics& statistics) {
  statistics.births = seedlings_.size();
  statistics.deaths = dying_.size();
  for (const std::uint32_t plant : dying_) {
    population.end(plant, completedSteps);
    transaction.forget(plant);
  }
  for (Seedling& seedling : seedlings_) {
    population.add(std::move(seedling.member), std::move(seedling.state), std::move(seedling.derivation));
  }
  transaction.setPlantCount(population.size());
  clear();
}

void BirthsAndDeaths::clear() {
  seeds_.clear();
  dying_.clear();
  seedlings_.clear();
}

}  // namespace espalier::simulation

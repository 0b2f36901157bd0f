#include "engine/simulation/step/derivation_pass.h"

#include <algorithm>
#include <exception>
#include <span>
#include <string>
#include <utility>

namespace espalier::simulation {

void DerivationPass::run(const std::vector<std::size_t>& plants, bool isKept, bool isFollowed,
                         std::uint64_t completedSteps) {
  isKept_ = isKept;
  isFollowed_ = isFollowed;
  completedSteps_ = completedSteps;
  derivedModules_ = 0;
  derivedBytes_ = 0;
  if (productions_->isFollowed()) {
    productions_->begin(population_->states().size());
  }
  if (ages_->isFollowed()) {
    ages_->begin(population_->states().size());
  }
  // small plants by several threads, or one plant after the other
  if (isWorthThreads(plants)) {
    deriveSideBySide(plants);
  } else {
    for (const std::size_t plant : plants) {
      derivePlant(plant);
    }
  }
  // the plants that were not derived have strings too
  if (population_->states().size() > 1) {
    const Population::Totals totals = population_->totals();
    requireTogether(totals.modules, totals.bytes);
  }
}

void DerivationPass::derivePlant(std::size_t plant) {
  // a plant's failed derivation changes nothing of it; the others are kept to be taken back
  derivation::PlantState& state = population_->states()[plant];
  if (isKept_) {
    transaction_->rememberUnderived(plant, state);
  }
  population_->derivation(plant).derive(state, isFollowed_ ? &transaction_->derivedChanges(plant) : nullptr,
                                        productions_->isFollowed() ? &productions_->of(plant) : nullptr,
                                        ages_->isFollowed() ? &ages_->of(plant) : nullptr);
  // the amounts of the plants before cannot become less: the outcome is the same in any order
  if (population_->states().size() > 1) {
    requireTogether(derivedModules_ += state.string.size(), derivedBytes_ += state.string.bytes());
  }
}

void DerivationPass::requireTogether(std::uint64_t modules, std::uint64_t bytes) const {
  std::string what;
  if (modules > options_->limits.maximumModules) {
    what = std::to_string(options_->limits.maximumModules) + " modules together (limit modules)";
  } else if (bytes > options_->limits.maximumStringBytes) {
    what = std::to_string(options_->limits.maximumStringBytes) + " bytes together (limit stringBytes)";
  } else {
    return;
  }
  core::SimulationError error;
  error.code = core::SimulationErrorCode::LimitExceeded;
  error.step = completedSteps_ + 1;
  error.message = "step " + std::to_string(error.step) + ": the strings of all plants have more than " + what +
                  ". Grow fewer plants, or raise the limit.";
  throw core::SimulationFailure(std::move(error));
}

unsigned DerivationPass::threadCount() const {
  return std::max(options_->threads, 1U);
}

bool DerivationPass::isLong(std::size_t plant) const {
  return population_->states()[plant].string.size() >= derivation::DerivationOptions{}.threadedModules;
}

bool DerivationPass::isWorthThreads(const std::vector<std::size_t>& plants) const {
  // long strings are derived by several threads each, the others side by side when it is worth waking the threads
  constexpr std::size_t kWorthwhileModules = 4096;
  std::size_t smallPlants = 0;
  std::size_t smallModules = 0;
  for (const std::size_t plant : plants) {
    if (!isLong(plant)) {
      ++smallPlants;
      smallModules += population_->states()[plant].string.size();
    }
  }
  return threadCount() >= 2 && smallPlants >= 2 && smallModules >= kWorthwhileModules;
}

void DerivationPass::deriveSideBySide(const std::vector<std::size_t>& plants) {
  // plants are taken in order; when one fails no further ones are taken, and those before it have been
  const auto threads = static_cast<unsigned>(std::min<std::size_t>(threadCount(), plants.size()));
  if (!team_ || team_->size() < threads) {
    team_ = std::make_unique<core::WorkerTeam>(threads);
  }
  messages_->hold(population_->states().size());
  std::vector<std::exception_ptr> failures(plants.size());
  std::atomic<std::size_t> next{0};
  std::atomic<bool> hasFailed{false};
  // strings grow meanwhile: which ones are long is decided before
  std::vector<std::uint8_t> isLater(plants.size());
  for (std::size_t i = 0; i < plants.size(); ++i) {
    isLater[i] = isLong(plants[i]) ? 1 : 0;
  }
  const auto derive = [&](std::size_t i) {
    try {
      derivePlant(plants[i]);
    } catch (...) {
      failures[i] = std::current_exception();
      hasFailed = true;
    }
  };
  team_->onEveryWorker([&](unsigned) {
    while (!hasFailed) {
      const std::size_t i = next++;
      if (i >= plants.size()) {
        return;
      }
      if (isLater[i] == 0) {
        derive(i);
      }
    }
  });
  const auto firstFailure = [&] {
    return static_cast<std::size_t>(
        std::find_if(failures.begin(), failures.end(), [](const auto& f) { return f != nullptr; }) - failures.begin());
  };
  // a long one before the first that failed may be the first to fail
  for (std::size_t i = 0; i < std::min(firstFailure(), plants.size()); ++i) {
    if (isLater[i] != 0) {
      derive(i);
    }
  }
  // as if they had been derived one after the other: what they say in order, up to the first failure
  const std::size_t failed = firstFailure();
  messages_->release(std::span(plants).first(std::min(failed + 1, plants.size())));
  if (failed < plants.size()) {
    std::rethrow_exception(failures[failed]);
  }
}

}  // namespace espalier::simulation

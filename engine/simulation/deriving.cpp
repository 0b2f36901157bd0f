#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>

#include "engine/simulation/simulation_implementation.h"
#include "engine/turtle/scene/scene_bounds.h"

namespace espalier::simulation {

namespace {

// by stop(n); a plant whose derivation length is reached goes on when it is asked to
bool hasStoppedItself(const derivation::PlantState& plant) {
  return plant.isStopped && plant.step < plant.derivationLength;
}

}  // namespace

void Simulation::Implementation::measureViewVolume() {
  // a model with a box of its own has it from the start
  const auto& programs = models_.programs();
  if (std::none_of(programs.begin(), programs.end(),
                   [](const auto& program) { return program->usesViewVolume && !program->view.box; })) {
    return;
  }
  turtle::Scene scene;
  if (auto error = draw({.scene = &scene})) {
    throw core::SimulationFailure(std::move(*error));
  }
  const files::Box volume = turtle::boundsOf(scene, models_.view()).value_or(files::Box{});
  for (derivation::PlantState& plant : plants_) {
    plant.viewVolume = volume;
  }
}

void Simulation::Implementation::derivePass() {
  // a file that cannot be written takes the derivation back as well
  const bool writesFiles = options_.fileWriter != nullptr && models_.writesFiles();
  const bool isKept = plants_.size() > 1 || writesFiles || !seeds_.empty();
  measureViewVolume();
  std::vector<std::size_t> growing;
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    if (isGrowing(plant) && !hasStoppedItself(plants_[plant])) {
      growing.push_back(plant);
    }
  }
  derivedModules_ = 0;
  derivedBytes_ = 0;
  deriveAll(growing, isKept);
  if (plants_.size() > 1) {
    std::uint64_t modules = 0;
    std::uint64_t bytes = 0;
    for (const derivation::PlantState& plant : plants_) {
      modules += plant.string.size();
      bytes += plant.string.bytes();
    }
    requireTogether(modules, bytes);
  }
  const bool hasDerived = !dying_.empty() || !growing.empty();
  if (!hasDerived) {
    core::SimulationError error;
    error.code = core::SimulationErrorCode::Model;
    error.step = completedSteps_ + 1;
    error.message = "step " + std::to_string(error.step) +
                    (livingPlantCount() == 0 ? ": no plant is alive" : ": the model has stopped itself") +
                    ", there is no further step. Rewind the simulation to run it again.";
    throw core::SimulationFailure(std::move(error));
  }
}

std::unique_ptr<derivation::Derivation> Simulation::Implementation::makeDerivation(std::uint32_t plant,
                                                                                   const Plant& member) {
  derivation::DerivationOptions options = derivationOptions(plant, member);
  if (options_.messages) {
    options.messages = [this, plant](core::MessageKind kind, std::string_view text) {
      deliverMessage(plant, kind, text);
    };
  }
  return std::make_unique<derivation::Derivation>(*models_.programs()[member.origin.model], std::move(options));
}

void Simulation::Implementation::derivePlant(std::size_t plant, bool isKept) {
  // a plant's failed derivation changes nothing of it; the others are kept to be taken back
  if (isKept) {
    undo_[plant].underived = plants_[plant];
    undo_[plant].hasUnderived = true;
  }
  derivations_[plant]->derive(plants_[plant]);
  // what those before have cannot become less: the outcome is the same in any order
  if (plants_.size() > 1) {
    const derivation::ModuleString& string = plants_[plant].string;
    requireTogether(derivedModules_ += string.size(), derivedBytes_ += string.bytes());
  }
}

void Simulation::Implementation::requireTogether(std::uint64_t modules, std::uint64_t bytes) const {
  std::string what;
  if (modules > options_.limits.maximumModules) {
    what = std::to_string(options_.limits.maximumModules) + " modules together (limit maximumModules)";
  } else if (bytes > options_.limits.maximumStringBytes) {
    what = std::to_string(options_.limits.maximumStringBytes) + " bytes together (limit maximumStringBytes)";
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

unsigned Simulation::Implementation::threadCount() const {
  return options_.threads == 0 ? std::max(std::thread::hardware_concurrency(), 1U) : options_.threads;
}

void Simulation::Implementation::deriveAll(const std::vector<std::size_t>& plants, bool isKept) {
  // long strings are derived by several threads each, the others side by side when it is worth waking the threads
  constexpr std::size_t kWorthwhileModules = 4096;
  const std::size_t longModules = derivation::DerivationOptions{}.threadedModules;
  std::vector<std::size_t> small;
  std::size_t smallModules = 0;
  for (const std::size_t plant : plants) {
    if (plants_[plant].string.size() < longModules) {
      small.push_back(plant);
      smallModules += plants_[plant].string.size();
    }
  }
  if (threadCount() < 2 || small.size() < 2 || smallModules < kWorthwhileModules) {
    for (const std::size_t plant : plants) {
      derivePlant(plant, isKept);
    }
    return;
  }
  deriveTogether(plants, isKept);
}

void Simulation::Implementation::deriveTogether(const std::vector<std::size_t>& plants, bool isKept) {
  // plants are taken in order; when one fails no further ones are taken, and those before it have been
  const auto threads = static_cast<unsigned>(std::min<std::size_t>(threadCount(), plants.size()));
  if (!team_ || team_->size() < threads) {
    team_ = std::make_unique<core::WorkerTeam>(threads);
  }
  heldMessages_.assign(plants_.size(), {});
  std::vector<std::exception_ptr> failures(plants.size());
  std::atomic<std::size_t> next{0};
  std::atomic<bool> hasFailed{false};
  const std::size_t longModules = derivation::DerivationOptions{}.threadedModules;
  // strings grow meanwhile: which ones are long is decided before
  std::vector<std::uint8_t> isLater(plants.size());
  for (std::size_t i = 0; i < plants.size(); ++i) {
    isLater[i] = plants_[plants[i]].string.size() >= longModules ? 1 : 0;
  }
  const auto derive = [&](std::size_t i) {
    try {
      derivePlant(plants[i], isKept);
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
  const auto held = std::move(heldMessages_);
  heldMessages_.clear();
  const std::size_t failed = firstFailure();
  for (std::size_t i = 0; i < plants.size() && i <= failed; ++i) {
    for (const auto& [kind, text] : held[plants[i]]) {
      options_.messages(kind, text);
    }
  }
  if (failed < plants.size()) {
    std::rethrow_exception(failures[failed]);
  }
}

void Simulation::Implementation::deliverMessage(std::uint32_t plant, core::MessageKind kind, std::string_view text) {
  if (heldMessages_.empty()) {
    options_.messages(kind, text);
  } else {
    heldMessages_[plant].emplace_back(kind, text);
  }
}

}  // namespace espalier::simulation

#include "engine/simulation/step/module_ages.h"

namespace espalier::simulation {

void ModuleAges::follow(bool isWanted, const std::vector<derivation::PlantState>& states) {
  isFollowed_ = isWanted;
  goTo(states, kUnknown);
}

void ModuleAges::begin(std::size_t plantCount) {
  origins_.resize(plantCount);
  for (derivation::ModuleOrigins& origins : origins_) {
    origins.clear();
  }
}

void ModuleAges::complete(const std::vector<derivation::PlantState>& states, std::uint64_t step) {
  for (std::size_t plant = 0; plant < states.size(); ++plant) {
    if (plant == births_.size()) {
      births_.emplace_back(states[plant].string.size(), step);
      continue;
    }
    std::vector<std::uint64_t>& births = births_[plant];
    const std::span<const std::uint64_t> from =
        plant < origins_.size() ? origins_[plant].from() : std::span<const std::uint64_t>();
    if (from.size() == states[plant].string.size()) {
      next_.clear();
      for (const std::uint64_t module : from) {
        next_.push_back(module < births.size() ? births[module] : step);
      }
      births.swap(next_);
    } else if (births.size() != states[plant].string.size()) {
      // it has ended
      births.assign(states[plant].string.size(), step);
    }
  }
}

void ModuleAges::goTo(const std::vector<derivation::PlantState>& states, std::uint64_t step) {
  births_.clear();
  for (std::size_t plant = 0; isFollowed_ && plant < states.size(); ++plant) {
    births_.emplace_back(states[plant].string.size(), step);
  }
}

std::span<const std::uint64_t> ModuleAges::births(std::size_t plant) const {
  return isFollowed_ && plant < births_.size() ? births_[plant] : std::span<const std::uint64_t>();
}

}  // namespace espalier::simulation

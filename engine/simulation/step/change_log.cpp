#include "engine/simulation/step/change_log.h"

#include <utility>

namespace espalier::simulation {

void ChangeLog::add(std::size_t plant, const derivation::StepChanges& changes) {
  if (plant < changes_.size()) {
    changes_[plant].join(changes, joined_);
    std::swap(changes_[plant], joined_);
  }
}

std::vector<derivation::StepChanges> ChangeLog::take(const std::vector<derivation::PlantState>& plants) {
  std::vector<derivation::StepChanges> changes = std::exchange(changes_, {});
  changes.resize(plants.size());
  if (isFollowed_) {
    for (const derivation::PlantState& plant : plants) {
      changes_.push_back(derivation::StepChanges::nothing(plant.string.size()));
    }
    isKnown_ = true;
  }
  return changes;
}

}  // namespace espalier::simulation

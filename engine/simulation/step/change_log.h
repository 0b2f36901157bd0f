#pragma once

#include <cstddef>
#include <vector>

#include "engine/derivation/state/plant_state.h"
#include "engine/derivation/state/step_changes.h"

namespace espalier::simulation {

/// Joins what happens to the strings of plants between two views of a simulation: answers, steps, edits, restores.
class ChangeLog {
 public:
  void follow(bool isWanted) {
    isFollowed_ = isWanted;
    if (!isWanted) {
      forget();
    }
  }
  [[nodiscard]] bool isFollowed() const { return isFollowed_; }
  /// Whether take() was called before and nothing was forgotten since.
  [[nodiscard]] bool isKnown() const { return isKnown_; }

  /// The string of a plant has changed.
  void add(std::size_t plant, const derivation::StepChanges& changes);
  /// The plants have become others.
  void forget() {
    isKnown_ = false;
    changes_.clear();
  }
  /// By plant: the changes since the last call. These are the plants now.
  [[nodiscard]] std::vector<derivation::StepChanges> take(const std::vector<derivation::PlantState>& plants);

 private:
  bool isFollowed_ = false;
  bool isKnown_ = false;
  std::vector<derivation::StepChanges> changes_;  // by plant; plants that came since are missing
  derivation::StepChanges joined_;                // working memory
};

}  // namespace espalier::simulation

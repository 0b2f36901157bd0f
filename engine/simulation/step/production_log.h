#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "engine/derivation/production_counts.h"
#include "engine/simulation/simulation.h"

namespace espalier::simulation {

/// How often the productions of a run were applied, after each of its last steps. A run that goes back to such a step
/// finds the figures of that step again. A step that is made again takes the place of the old one and of those after
/// it.
class ProductionLog {
 public:
  void follow(bool isWanted, std::uint64_t completedSteps);
  [[nodiscard]] bool isFollowed() const { return isFollowed_; }

  /// A step begins: `of` has an empty place for each plant. Plants may be derived side by side.
  void begin(std::size_t plantCount) { counts_.assign(plantCount, {}); }
  [[nodiscard]] derivation::ProductionCounts& of(std::size_t plant) { return counts_[plant]; }
  /// The step is complete; `step` is its number.
  void complete(std::uint64_t step);
  /// The run is at this step now, by a rewind or a restored state. The count begins anew where the log does not know
  /// the step.
  void goTo(std::uint64_t step);

  /// Bytes of memory, about.
  [[nodiscard]] std::uint64_t bytes() const;
  /// The counts at the step where the run is. Null: not followed.
  [[nodiscard]] std::shared_ptr<const ProductionUses> uses() const { return isFollowed_ ? present_ : nullptr; }

 private:
  void beginAt(std::uint64_t step);

  bool isFollowed_ = false;
  std::vector<derivation::ProductionCounts> counts_;         // of the step under way, by plant
  std::deque<std::shared_ptr<const ProductionUses>> steps_;  // of steps in a row
  std::uint64_t useCount_ = 0;                               // entries of all of them
  std::shared_ptr<const ProductionUses> present_;
};

}  // namespace espalier::simulation

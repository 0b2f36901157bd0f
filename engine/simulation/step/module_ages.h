#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/derivation/state/module_origins.h"
#include "engine/derivation/state/plant_state.h"

namespace espalier::simulation {

/// The steps in which the modules of the plants came, for plants whose steps were all followed.
class ModuleAges {
 public:
  static constexpr std::uint64_t kUnknown = ~std::uint64_t{0};

  /// Modules that are there already came in a step that is not known.
  void follow(bool isWanted, const std::vector<derivation::PlantState>& states);
  [[nodiscard]] bool isFollowed() const { return isFollowed_; }

  /// A step begins: `of` has an empty place for each plant. Plants may be derived side by side.
  void begin(std::size_t plantCount);
  [[nodiscard]] derivation::ModuleOrigins& of(std::size_t plant) { return origins_[plant]; }
  /// The step is complete; `step` is its number. Plants that came in it are new.
  void complete(const std::vector<derivation::PlantState>& states, std::uint64_t step);
  /// The run is at another step now, by a rewind (all modules came in step 0) or a restored state (kUnknown).
  void goTo(const std::vector<derivation::PlantState>& states, std::uint64_t step);

  /// By module. Empty: not followed.
  [[nodiscard]] std::span<const std::uint64_t> births(std::size_t plant) const;

 private:
  bool isFollowed_ = false;
  std::vector<derivation::ModuleOrigins> origins_;  // of the step under way, by plant; empty: not derived
  std::vector<std::vector<std::uint64_t>> births_;  // by plant, by module
  std::vector<std::uint64_t> next_;                 // working memory
};

}  // namespace espalier::simulation

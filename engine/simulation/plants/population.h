#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/hash.h"
#include "engine/core/vec3.h"
#include "engine/derivation/derivation.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/simulation/forest.h"
#include "engine/simulation/model_set.h"
#include "engine/simulation/plants/derivation_factory.h"

namespace espalier::simulation {

/// The plants of a simulation by number, living and dead: where each one comes from, its state, and the Derivations
/// that advance and draw it. Before the run starts the plants have no states.
class Population {
 public:
  /// `models` and `factory` must outlive the object.
  Population(const ModelSet& models, const DerivationFactory& factory, std::vector<Plant> members);

  [[nodiscard]] std::size_t size() const { return members_.size(); }
  [[nodiscard]] std::uint64_t livingCount() const;
  [[nodiscard]] const std::vector<Plant>& members() const { return members_; }
  /// The same as a value for views, until plants come or go.
  [[nodiscard]] const std::shared_ptr<const std::vector<Plant>>& sharedMembers();
  [[nodiscard]] const Plant& member(std::size_t plant) const { return members_[plant]; }
  [[nodiscard]] const language::Program& program(std::size_t plant) const {
    return *models_->programs()[members_[plant].origin.model];
  }
  [[nodiscard]] turtle::Interpreter& interpreter(std::size_t plant) const {
    return models_->interpreter(members_[plant].origin.model);
  }

  /// By plant number; of the dead empty.
  [[nodiscard]] std::vector<derivation::PlantState>& states() { return states_; }
  [[nodiscard]] const std::vector<derivation::PlantState>& states() const { return states_; }
  void setStates(std::vector<derivation::PlantState> states) { states_ = std::move(states); }

  /// The Derivation of a living plant.
  [[nodiscard]] derivation::Derivation& derivation(std::size_t plant) const { return *derivations_[plant]; }

  /// The factory has another seed: the next rewinds draw from it.
  void reseed();

  /// The plants that were there at step 0, all alive.
  [[nodiscard]] std::vector<Plant> founders() const;
  /// Where the living plants stand.
  [[nodiscard]] std::vector<core::Vec3> places() const;
  /// The new plant has the next number.
  void add(Plant member, derivation::PlantState state, std::unique_ptr<derivation::Derivation> derivation);
  /// A plant that ends keeps its number and its counters.
  void end(std::size_t plant, std::uint64_t deathStep);

  /// The sizes of all strings together.
  struct Totals {
    std::uint64_t modules = 0;
    std::uint64_t parameters = 0;
    std::uint64_t bytes = 0;
  };
  [[nodiscard]] Totals totals() const;
  /// Steps until every plant has reached its own derivation length.
  [[nodiscard]] std::uint64_t derivationLength() const;
  /// Whether every living plant has stopped or reached its length after so many steps.
  [[nodiscard]] bool isFinished(std::uint64_t completedSteps) const;
  void hash(core::Hasher& hasher) const;

 private:
  const ModelSet* models_;
  const DerivationFactory* factory_;
  // by plant number
  std::vector<Plant> members_;
  std::vector<derivation::PlantState> states_;
  std::vector<std::unique_ptr<derivation::Derivation>> derivations_;  // null: of a dead plant
  std::shared_ptr<const std::vector<Plant>> sharedMembers_;           // null: they have changed
};

}  // namespace espalier::simulation

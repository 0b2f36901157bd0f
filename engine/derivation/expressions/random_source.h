#pragma once

#include <array>
#include <cstdint>

#include "engine/core/identifiers.h"
#include "engine/core/random.h"
#include "engine/derivation/state/plant_state.h"

namespace espalier::derivation {

/// All random numbers of one plant, in both modes (LANGUAGE §1.3).
///
/// Espalier's own mode: counter-based; a draw is named by (seed, plant, domain, step, index, draw number). key() names
/// the first three of them and starts counting draws at 0. The compatible modes: two sequential streams held in
/// RandomState, and key() has no effect.
class RandomSource {
 public:
  RandomSource(core::Compatibility compatibility, std::uint32_t plant);

  /// The state that streams and seeds are kept in; it must outlive the next attach. Called before any other function.
  void attach(RandomState& state);

  /// The following draws are number 0, 1, ... of module `index` in step `step`.
  void key(core::DrawDomain domain, std::uint64_t step, std::uint64_t index) {
    domain_ = domain;
    step_ = static_cast<std::uint32_t>(step);
    index_ = index;
    draw_ = 0;
  }

  /// Uniform in [0, 1), from the main stream.
  [[nodiscard]] double uniform();
  /// Normally distributed, by the polar Box-Muller method. The reference keeps the second value of a pair for the next
  /// call; Espalier's own mode makes a fresh pair each time, so that no module depends on the one before.
  [[nodiscard]] double normal(double mean, double deviation);
  /// Beta distributed: algorithm BA of Cheng (1978).
  [[nodiscard]] double beta(double a, double b);
  /// Binomially distributed: the number of `count` draws that are at most `probability`.
  [[nodiscard]] double binomial(double count, double probability);
  /// srand: seeds the main stream (an integer part; the reference uses its low 32 bits) and drops a kept normal value.
  void seed(double value);

  /// The selection draw of a string position, uniform in [0, 1). In Espalier's own mode a pure function of (step,
  /// index); in the compatible modes the next value of the selection stream.
  [[nodiscard]] double selection(std::uint64_t step, std::uint64_t index) {
    if (isSequential_) {
      return state_->selection.uniform();
    }
    // four neighbours share a block
    const std::uint64_t block = index >> 2U;
    if (block != selectionBlock_ || step != selectionStep_) {
      loadSelectionBlock(step, block);
    }
    return static_cast<double>(selectionWords_[index & 3U]) * 0x1.0p-32;
  }
  /// What selection() draws from in Espalier's own mode.
  [[nodiscard]] const core::CounterRandom& selectionSource() const { return selection_; }
  /// What uniform() draws from in Espalier's own mode.
  [[nodiscard]] const core::CounterRandom& mainSource() const { return main_; }
  [[nodiscard]] bool isSequential() const { return isSequential_; }

  /// Creates the stream that a homomorphism's own seed names. Between usePrivateStream(true) and (false) the main
  /// stream is replaced by it.
  void startPrivateStream(double seed);
  void usePrivateStream(bool isUsed);

 private:
  void loadSelectionBlock(std::uint64_t step, std::uint64_t block);

  bool isSequential_;
  std::uint32_t plant_;
  RandomState* state_ = nullptr;   // owned by the PlantState of the current call
  core::CounterRandom selection_;  // of state_->seed
  core::CounterRandom main_;       // of state_->mainSeed
  core::DrawDomain domain_ = core::DrawDomain::Blocks;
  std::uint32_t step_ = 0;
  std::uint64_t index_ = 0;
  std::uint32_t draw_ = 0;
  std::uint64_t selectionStep_ = ~std::uint64_t{0};
  std::uint64_t selectionBlock_ = ~std::uint64_t{0};
  std::array<std::uint32_t, 4> selectionWords_{};
  RandomState private_;  // the stream that is not in use: private, or main while the private one is in state_
  bool isPrivate_ = false;
};

}  // namespace espalier::derivation

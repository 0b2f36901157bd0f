#pragma once

#include <array>
#include <cstdint>

#include "engine/core/elementary.h"
#include "engine/core/identifiers.h"
#include "engine/core/random.h"
#include "engine/derivation/state/plant_state.h"

namespace espalier::derivation {

/// All random numbers of one plant, in all modes (docs/language.md, 1.3).
///
/// Espalier's own mode is counter-based: (seed, plant, domain, step, index, draw number) name a draw. key() gives
/// domain, step and index, and counts draws from 0 again. The compatible modes use the two sequential streams of
/// RandomState; there key() has no effect.
class RandomSource {
 public:
  RandomSource(core::Compatibility compatibility, std::uint32_t plant);

  /// Uses the streams and seeds of `state`, which must stay in place until the next attach. Comes before every other
  /// call.
  void attach(RandomState& state);

  /// The following draws are number 0, 1, ... of module `index` in step `step`.
  void key(core::DrawDomain domain, std::uint64_t step, std::uint64_t index) {
    domain_ = domain;
    step_ = static_cast<std::uint32_t>(step);
    index_ = index;
    restartDraws();
  }

  /// Uniform in [0, 1), from the main stream.
  [[nodiscard]] double uniform();
  /// Normally distributed, by the polar Box-Muller method. The reference program keeps the second value of a pair for
  /// the next call. Espalier's own mode makes a fresh pair each time, so that no module depends on the module before.
  [[nodiscard]] double normal(double mean, double deviation);
  /// Beta distributed: algorithm BA of Cheng (1978).
  [[nodiscard]] double beta(double a, double b);
  /// Binomially distributed: the number of `count` draws that are at most `probability`.
  [[nodiscard]] double binomial(double count, double probability);
  /// srand: seeds the main stream with the integer part (the reference: its low 32 bits) and drops a kept normal value.
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
  /// The generator of selection() in Espalier's own mode.
  [[nodiscard]] const core::CounterRandom& selectionSource() const { return selection_; }
  /// The generator of uniform() in Espalier's own mode.
  [[nodiscard]] const core::CounterRandom& mainSource() const { return main_; }
  [[nodiscard]] bool isSequential() const { return isSequential_; }

  /// Creates the stream of a homomorphism's own seed. It replaces the main stream between usePrivateStream(true) and
  /// usePrivateStream(false).
  void startPrivateStream(double seed);
  void usePrivateStream(bool isUsed);

 private:
  static constexpr std::uint32_t kNoPair = ~std::uint32_t{0};

  void loadSelectionBlock(std::uint64_t step, std::uint64_t block);
  void restartDraws() {
    draw_ = 0;
    pair_ = kNoPair;
  }

  bool isSequential_;
  core::Elementary elementary_;
  std::uint32_t plant_;
  RandomState* state_ = nullptr;   // of the attached plant
  core::CounterRandom selection_;  // of state_->seed
  core::CounterRandom main_;       // of state_->mainSeed
  core::DrawDomain domain_ = core::DrawDomain::Blocks;
  std::uint32_t step_ = 0;
  std::uint64_t index_ = 0;
  std::uint32_t draw_ = 0;
  std::uint32_t pair_ = kNoPair;  // known draws of the main stream: 2 * pair_ and the next
  std::array<double, 2> numbers_{};
  std::uint64_t selectionStep_ = ~std::uint64_t{0};
  std::uint64_t selectionBlock_ = ~std::uint64_t{0};
  std::array<std::uint32_t, 4> selectionWords_{};
  RandomState private_;  // the private stream, or the main stream while the private one is in state_
  bool isPrivate_ = false;
};

}  // namespace espalier::derivation

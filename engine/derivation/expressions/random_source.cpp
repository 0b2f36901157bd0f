#include "engine/derivation/expressions/random_source.h"

#include <cmath>
#include <utility>

#include "engine/derivation/expressions/distributions.h"

namespace espalier::derivation {
namespace {

/// The integer part as 64 bits, negative numbers in two's complement; 0 when the number has no 64-bit integer part.
std::uint64_t integerSeed(double value) {
  if (!(std::fabs(value) < 9.0e18)) {
    return 0;
  }
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(value));
}

/// The reference's main stream after srand of this number.
core::SequentialRandom seededStream(double value) {
  return core::SequentialRandom(((integerSeed(value) & 0xFFFFFFFFU) << 16U) | 0x330EU);
}

}  // namespace

RandomSource::RandomSource(core::Compatibility compatibility, std::uint32_t plant)
    : isSequential_(compatibility != core::Compatibility::Espalier), elementary_(compatibility), plant_(plant) {}

void RandomSource::attach(RandomState& state) {
  state_ = &state;
  isPrivate_ = false;
  if (!isSequential_) {
    selection_ = core::CounterRandom(state.seed, plant_);
    main_ = core::CounterRandom(state.mainSeed, plant_);
    pair_ = kNoPair;
    selectionBlock_ = ~std::uint64_t{0};
  }
}

double RandomSource::uniform() {
  if (isSequential_) {
    return state_->main.uniform();
  }
  const std::uint32_t number = draw_++;
  if (pair_ != number / 2) {
    pair_ = number / 2;
    numbers_ = core::CounterRandom::pairOf(main_.block(domain_, step_, index_, pair_));
  }
  return numbers_[number % 2];
}

double RandomSource::normal(double mean, double deviation) {
  if (isSequential_ && state_->normalCacheFlag != 0.0) {
    state_->normalCacheFlag = 0.0;
    return mean + deviation * state_->normalCache;
  }
  const NormalPair pair = drawNormalPair([this] { return uniform(); }, elementary_);
  if (isSequential_) {
    state_->normalCache = pair.first * pair.factor;
    state_->normalCacheFlag = 1.0;
  }
  return mean + deviation * pair.second * pair.factor;
}

double RandomSource::beta(double a, double b) {
  return drawBeta([this] { return uniform(); }, elementary_, a, b);
}

double RandomSource::binomial(double count, double probability) {
  double successes = 0.0;
  for (double i = 0.0; i < count; i += 1.0) {
    if (uniform() <= probability) {
      successes += 1.0;
    }
  }
  return successes;
}

void RandomSource::seed(double value) {
  if (isSequential_) {
    state_->main = seededStream(value);
    state_->normalCacheFlag = 0.0;
    return;
  }
  const std::uint64_t seed = integerSeed(value);
  (isPrivate_ ? private_ : *state_).mainSeed = seed;
  main_ = core::CounterRandom(seed, plant_);
  restartDraws();
}

void RandomSource::loadSelectionBlock(std::uint64_t step, std::uint64_t block) {
  selectionWords_ = selection_.block(core::DrawDomain::Selection, static_cast<std::uint32_t>(step), block, 0);
  selectionStep_ = step;
  selectionBlock_ = block;
}

void RandomSource::startPrivateStream(double seed) {
  private_ = RandomState{};
  private_.main = seededStream(seed);
  private_.mainSeed = integerSeed(seed);
  private_.normalCacheFlag = 0.0;
}

void RandomSource::usePrivateStream(bool isUsed) {
  if (isUsed == isPrivate_) {
    return;
  }
  isPrivate_ = isUsed;
  if (isSequential_) {
    std::swap(state_->main, private_.main);
    std::swap(state_->normalCache, private_.normalCache);
    std::swap(state_->normalCacheFlag, private_.normalCacheFlag);
    return;
  }
  main_ = core::CounterRandom(isUsed ? private_.mainSeed : state_->mainSeed, plant_);
  pair_ = kNoPair;
}

}  // namespace espalier::derivation

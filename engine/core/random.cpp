#include "engine/core/random.h"

#include <Random123/philox.h>

namespace espalier::core {
namespace {

// SplitMix64's finaliser (Steele, Lea & Flood 2014): spreads (seed, plant) over the key
std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31U);
}

}  // namespace

CounterRandom::CounterRandom(std::uint64_t seed, std::uint32_t plant) {
  const std::uint64_t key = mix(seed + 0x9e3779b97f4a7c15ULL * (std::uint64_t{plant} + 1));
  key_ = {static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(key >> 32U)};
}

std::array<std::uint32_t, 4> CounterRandom::block(DrawDomain domain, std::uint32_t step, std::uint64_t index,
                                                  std::uint32_t blockIndex) const {
  const r123::Philox4x32::ctr_type counter = {{static_cast<std::uint32_t>(index),
                                               static_cast<std::uint32_t>(index >> 32U), step,
                                               lastWord(domain, blockIndex)}};
  const r123::Philox4x32::key_type key = {{key_[0], key_[1]}};
  const r123::Philox4x32::ctr_type words = r123::Philox4x32()(counter, key);
  return {words[0], words[1], words[2], words[3]};
}

double CounterRandom::uniform(DrawDomain domain, std::uint32_t step, std::uint64_t index, std::uint32_t draw) const {
  // a block of four words serves two draws
  return pairOf(block(domain, step, index, draw / 2))[draw % 2];
}

double CounterRandom::selection(std::uint32_t step, std::uint64_t index) const {
  const std::array<std::uint32_t, 4> words = block(DrawDomain::Selection, step, index >> 2U, 0);
  return static_cast<double>(words[index & 3U]) * 0x1.0p-32;
}

}  // namespace espalier::core

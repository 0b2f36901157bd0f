#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace espalier::core {

/// The purpose of a draw. Draws of different domains are independent.
enum class DrawDomain : std::uint32_t {
  Selection = 0,       // choice among stochastic productions
  Production = 1,      // ran and its relatives in productions (blocks, conditions, successors)
  Decomposition = 2,   // the same in decomposition productions
  Interpretation = 3,  // the same in homomorphism productions
  Blocks = 4,          // the same in Start, StartEach, EndEach, End and the axiom
  Environment = 5,     // environment processes
};

/// Counter-based random numbers: Philox4x32-10 (Salmon et al. 2011) keyed by (seed, plant), with the counter (index,
/// step, domain, block). A draw is a pure function of (seed, plant, step, domain, index, draw). So any thread can
/// derive any part of a string, and a checkpoint needs no state of a generator.
class CounterRandom {
 public:
  CounterRandom() = default;
  CounterRandom(std::uint64_t seed, std::uint32_t plant);

  /// Draw number `draw` of module `index` in step `step`: uniform in [0, 1) with 53 bits.
  [[nodiscard]] double uniform(DrawDomain domain, std::uint32_t step, std::uint64_t index, std::uint32_t draw) const;

  /// The draws 2 * pairs[i] and 2 * pairs[i] + 1 of module indices[i], as numbers[2 * i] and numbers[2 * i + 1], for
  /// `count` of them. A pair costs little more than a draw, and many at once cost a fraction of many single calls.
  void uniformPairs(DrawDomain domain, std::uint32_t step, std::size_t count, const std::uint64_t* indices,
                    const std::uint32_t* pairs, double* numbers) const;

  /// The selection draw of module `index`: uniform in [0, 1) with 32 bits. Four neighbouring modules share one block.
  [[nodiscard]] double selection(std::uint32_t step, std::uint64_t index) const;

  /// The words behind selection() of the modules 4 * firstBlock, 4 * firstBlock + 1, ... (4 * blockCount): selection()
  /// is a word times 2^-32. Many at once cost a fraction of many single calls.
  void selectionWords(std::uint32_t step, std::uint64_t firstBlock, std::size_t blockCount, std::uint32_t* words) const;

  /// The raw block of four words.
  [[nodiscard]] std::array<std::uint32_t, 4> block(DrawDomain domain, std::uint32_t step, std::uint64_t index,
                                                   std::uint32_t blockIndex) const;
  /// The two draws of a block of four words.
  [[nodiscard]] static std::array<double, 2> pairOf(const std::array<std::uint32_t, 4>& words) {
    const auto number = [](std::uint32_t high, std::uint32_t low) {
      return static_cast<double>(((std::uint64_t{high} << 32U) | low) >> 11U) * 0x1.0p-53;
    };
    return {number(words[0], words[1]), number(words[2], words[3])};
  }

 private:
  /// The last word of a counter.
  [[nodiscard]] static std::uint32_t lastWord(DrawDomain domain, std::uint32_t blockIndex) {
    constexpr std::uint32_t kDomainShift = 28;
    return (static_cast<std::uint32_t>(domain) << kDomainShift) ^ blockIndex;
  }

  std::array<std::uint32_t, 2> key_{0, 0};
};

/// The reference program's sequential generator: X <- (0x5DEECE66D X + 0xB) mod 2^48, value X / 2^48.
class SequentialRandom {
 public:
  constexpr SequentialRandom() = default;
  constexpr explicit SequentialRandom(std::uint64_t state) : state_(state & kMask) {}
  [[nodiscard]] double uniform() {
    state_ = (0x5DEECE66DULL * state_ + 0xBULL) & kMask;
    return static_cast<double>(state_) / 281474976710656.0;
  }
  [[nodiscard]] constexpr std::uint64_t state() const { return state_; }
  constexpr void setState(std::uint64_t state) { state_ = state & kMask; }

 private:
  static constexpr std::uint64_t kMask = (1ULL << 48U) - 1;
  std::uint64_t state_ = 0;
};

}  // namespace espalier::core

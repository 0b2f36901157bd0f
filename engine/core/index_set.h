#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace espalier::core {

/// A set of numbers below a count that finds the next member after a number: a bit for each number, and a bit for each
/// word of bits that has members.
class IndexSet {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  explicit IndexSet(std::uint32_t count) : words_((count + 63U) / 64U), summary_((words_.size() + 63U) / 64U) {}

  void insert(std::uint32_t number) {
    words_[number / 64] |= bit(number);
    summary_[number / 4096] |= bit(number / 64);
  }
  void erase(std::uint32_t number) {
    words_[number / 64] &= ~bit(number);
    if (words_[number / 64] == 0) {
      summary_[number / 4096] &= ~bit(number / 64);
    }
  }

  /// The least member that is not below `number`; kNone: there is none. Looks at one word for 4096 numbers.
  [[nodiscard]] std::uint32_t from(std::uint32_t number) const {
    if (const std::uint32_t k = firstFrom(words_, number, number / 64 + 1); k != kNone) {
      return k;
    }
    const std::uint32_t word = firstFrom(summary_, number / 64 + 1, summary_.size());
    return word == kNone ? kNone : firstFrom(words_, 64 * word, word + 1);
  }

 private:
  static constexpr std::uint64_t bit(std::uint32_t number) { return std::uint64_t{1} << (number % 64); }

  // the first bit that is set, from a bit to the end of the words
  static std::uint32_t firstFrom(const std::vector<std::uint64_t>& words, std::uint32_t number, std::size_t end) {
    std::uint64_t mask = ~(bit(number) - 1);
    for (std::uint32_t i = number / 64; i < end; ++i, mask = ~std::uint64_t{0}) {
      if ((words[i] & mask) != 0) {
        return 64 * i + static_cast<std::uint32_t>(std::countr_zero(words[i] & mask));
      }
    }
    return kNone;
  }

  std::vector<std::uint64_t> words_;
  std::vector<std::uint64_t> summary_;  // a bit for each word that is not 0
};

}  // namespace espalier::core

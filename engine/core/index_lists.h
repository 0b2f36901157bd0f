#pragma once

#include <cstdint>
#include <vector>

namespace espalier::core {

/// Lists of numbers below a count. A number is in at most one list at a time, and leaves it in O(1).
class IndexLists {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  IndexLists(std::size_t listCount, std::size_t numberCount)
      : first_(listCount, kNone), next_(numberCount), before_(numberCount) {}

  /// The first number of a list and the one after a number; kNone: no more.
  [[nodiscard]] std::uint32_t first(std::size_t list) const { return first_[list]; }
  [[nodiscard]] std::uint32_t next(std::uint32_t number) const { return next_[number]; }

  /// The number is in no list yet.
  void insert(std::size_t list, std::uint32_t number) {
    std::uint32_t& first = first_[list];
    before_[number] = kNone;
    next_[number] = first;
    if (first != kNone) {
      before_[first] = number;
    }
    first = number;
  }

  /// The number is in this list.
  void remove(std::size_t list, std::uint32_t number) {
    const std::uint32_t before = before_[number];
    const std::uint32_t next = next_[number];
    (before != kNone ? next_[before] : first_[list]) = next;
    if (next != kNone) {
      before_[next] = before;
    }
  }

 private:
  std::vector<std::uint32_t> first_;          // by list
  std::vector<std::uint32_t> next_, before_;  // in the list, by number
};

}  // namespace espalier::core

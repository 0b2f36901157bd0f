#include "engine/derivation/state/step_changes.h"

#include <algorithm>
#include <cstring>

namespace espalier::derivation {
namespace {

/// How many elements are equal from the beginning on, bit by bit.
template <typename T>
std::uint64_t equalCount(const T* a, const T* b, std::uint64_t count) {
  constexpr std::uint64_t kBlock = 256;
  std::uint64_t i = 0;
  while (i + kBlock <= count && std::memcmp(a + i, b + i, kBlock * sizeof(T)) == 0) {
    i += kBlock;
  }
  while (i < count && std::memcmp(a + i, b + i, sizeof(T)) == 0) {
    ++i;
  }
  return i;
}

/// The same from the end backwards; the pointers are behind the last elements.
template <typename T>
std::uint64_t equalCountFromEnd(const T* a, const T* b, std::uint64_t count) {
  constexpr std::uint64_t kBlock = 256;
  std::uint64_t i = 0;
  while (i + kBlock <= count && std::memcmp(a - i - kBlock, b - i - kBlock, kBlock * sizeof(T)) == 0) {
    i += kBlock;
  }
  while (i < count && std::memcmp(a - i - 1, b - i - 1, sizeof(T)) == 0) {
    ++i;
  }
  return i;
}

}  // namespace

StepChanges StepChanges::nothing(std::uint64_t modules) {
  StepChanges changes;
  changes.keep(0, 0, modules);
  return changes;
}

StepChanges StepChanges::between(const ModuleString& older, const ModuleString& newer,
                                 std::span<const std::uint16_t> arity) {
  StepChanges changes;
  changes.keepEqualEnds({older.types(), older.parameters(), 0}, {newer.types(), newer.parameters(), 0}, arity);
  return changes;
}

StepChanges StepChanges::ofParameters(std::span<const std::uint64_t> modules, std::uint64_t moduleCount) {
  StepChanges changes;
  std::uint64_t begin = 0;
  for (const std::uint64_t module : modules) {
    if (module >= begin + kShortestRun) {
      changes.keep(begin, begin, module - begin);
    }
    begin = std::max(begin, module + 2);
  }
  if (begin < moduleCount) {
    changes.keep(begin, begin, moduleCount - begin);
  }
  return changes;
}

void StepChanges::keep(std::uint64_t from, std::uint64_t to, std::uint64_t modules) {
  if (modules == 0) {
    return;
  }
  // goes on with the last run where it can
  if (!kept_.empty()) {
    KeptModules& last = kept_.back();
    if (last.from + last.modules == from && last.to + last.modules == to) {
      last.modules += modules;
      return;
    }
  }
  kept_.push_back({from, to, modules});
}

StepChanges StepChanges::then(const StepChanges& next) const {
  StepChanges result;
  join(next, result);
  return result;
}

void StepChanges::join(const StepChanges& next, StepChanges& result) const {
  result.clear();
  auto a = kept_.begin();
  auto b = next.kept_.begin();
  while (a != kept_.end() && b != next.kept_.end()) {
    // positions in the string between the two changes
    const std::uint64_t begin = std::max(a->to, b->from);
    const std::uint64_t end = std::min(a->to + a->modules, b->from + b->modules);
    if (begin < end) {
      result.keep(a->from + (begin - a->to), b->to + (begin - b->from), end - begin);
    }
    (a->to + a->modules < b->from + b->modules) ? ++a : ++b;
  }
}

void StepChanges::keepEqualEnds(const StringStretch& older, const StringStretch& newer,
                                std::span<const std::uint16_t> arity) {
  const std::uint64_t modules = std::min(older.types.size(), newer.types.size());
  const std::uint64_t values = std::min(older.parameters.size(), newer.parameters.size());

  // from the beginning
  std::uint64_t first = equalCount(older.types.data(), newer.types.data(), modules);
  std::uint64_t firstValues = equalCount(older.parameters.data(), newer.parameters.data(), values);
  if (first < older.types.size() || firstValues < older.parameters.size()) {
    // the modules whose parameters are among those
    const std::uint64_t sameTypes = first;
    const std::uint64_t sameValues = firstValues;
    firstValues = 0;
    for (first = 0; first < sameTypes; ++first) {
      const std::uint64_t count = arity[older.types[first]];
      if (firstValues + count > sameValues) {
        break;
      }
      firstValues += count;
    }
  }
  keep(older.first, newer.first, first);

  // from the end, as far as the beginning did not reach
  const std::uint64_t endTypes = equalCountFromEnd(older.types.data() + older.types.size(),
                                                   newer.types.data() + newer.types.size(), modules - first);
  const std::uint64_t endValues =
      equalCountFromEnd(older.parameters.data() + older.parameters.size(),
                        newer.parameters.data() + newer.parameters.size(), values - firstValues);
  std::uint64_t last = 0;
  for (std::uint64_t used = 0; last < endTypes; ++last) {
    used += arity[older.types[older.types.size() - last - 1]];
    if (used > endValues) {
      break;
    }
  }
  keep(older.first + older.types.size() - last, newer.first + newer.types.size() - last, last);
}

}  // namespace espalier::derivation

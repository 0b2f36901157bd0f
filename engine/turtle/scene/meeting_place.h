#pragma once

#include <cstddef>
#include <optional>
#include <utility>

namespace espalier::turtle {

/// Resynchronises two lists that differ: how many elements of the earlier and of the later list to skip.
/// `isAlike(removed, added)` compares the elements behind so many. The nearest place is tried first: up to 8 elements
/// changed together, and up to `farthest` that only one list has. Nothing when the lists do not meet there.
template <typename IsAlike>
[[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> meetingPlace(std::size_t farthest,
                                                                              const IsAlike& isAlike) {
  constexpr std::size_t kChangedTogether = 8;
  for (std::size_t sum = 1; sum <= farthest; ++sum) {
    const std::size_t stride = sum <= kChangedTogether ? 1 : sum;
    for (std::size_t added = 0; added <= sum; added += stride) {
      if (isAlike(sum - added, added)) {
        return std::pair(sum - added, added);
      }
    }
  }
  return std::nullopt;
}

}  // namespace espalier::turtle

#pragma once

#include <cstddef>
#include <optional>
#include <utility>

namespace espalier::turtle {

/// Where two lists that have parted go on alike: how many elements of the earlier and of the later one are left out.
/// `isAlike(removed, added)` compares the elements behind so many. Looks nearest first, at up to 8 changed together and
/// at up to `farthest` that only one of the lists has; nothing when they do not meet there.
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

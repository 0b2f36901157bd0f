#include "protocol/decoding/near_name.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace espalier::protocol {
namespace {

std::size_t distanceOf(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) {
    row[j] = j;
  }
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

}  // namespace

std::string_view nearName(std::string_view name, std::span<const std::string_view> candidates) {
  std::string_view nearest;
  std::size_t least = 0;
  for (const std::string_view candidate : candidates) {
    const std::size_t most = std::min(name.size(), candidate.size()) > 3 ? 2 : 1;
    // a longer name is not near, and a person may have pasted anything
    if (std::max(name.size(), candidate.size()) > std::min(name.size(), candidate.size()) + most) {
      continue;
    }
    const std::size_t distance = distanceOf(name, candidate);
    if (distance <= most && (nearest.empty() || distance < least)) {
      nearest = candidate;
      least = distance;
    }
  }
  return nearest;
}

}  // namespace espalier::protocol

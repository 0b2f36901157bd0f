#include "environment/competition/tip_collisions.h"

#include <tuple>

namespace espalier::environment {

bool TipCollisions::isSamePlace(std::uint32_t a, std::uint32_t b) const {
  return tips_[a].group == tips_[b].group && tips_[a].position == tips_[b].position;
}

std::vector<std::uint32_t> TipCollisions::orderByPlace() const {
  std::vector<std::uint32_t> order(tips_.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto keyOf = [&](std::uint32_t tip) {
    const Tip& t = tips_[tip];
    return std::tuple(t.group, t.position.x, t.position.y, t.position.z, -t.vigor);
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return keyOf(a) < keyOf(b); });
  return order;
}

/// Members of a cell by group, then the strongest first: the tips that can block come first.
void TipCollisions::sortMembers(SpatialCells& cells) const {
  for (std::size_t cell = 0; cell < cells.cellCount(); ++cell) {
    const auto members = cells.members(cell);
    std::sort(members.begin(), members.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::tuple(tips_[a].group, -tips_[a].vigor) < std::tuple(tips_[b].group, -tips_[b].vigor);
    });
  }
}

}  // namespace espalier::environment

#include "environment/competition/zone_grid.h"

#include <algorithm>
#include <cmath>

namespace espalier::environment {
namespace {

// so that a point that rounding puts into a disc is in its box
double widened(const ZoneGrid::Disc& disc, double coordinate) {
  return disc.radius * (1.0 + 1e-9) + std::abs(coordinate) * 1e-12;
}

}  // namespace

ZoneGrid::ZoneGrid(std::span<const Disc> discs) {
  if (discs.empty()) {
    return;
  }
  std::array<double, 2> high{discs[0].x, discs[0].z};
  low_ = high;
  for (const Disc& disc : discs) {
    const double wideX = widened(disc, disc.x);
    const double wideZ = widened(disc, disc.z);
    low_ = {std::min(low_[0], disc.x - wideX), std::min(low_[1], disc.z - wideZ)};
    high = {std::max(high[0], disc.x + wideX), std::max(high[1], disc.z + wideZ)};
  }
  // about two cells for each disc, fewer when the discs are so large that most cells would list most of them
  const std::array<double, 2> extent{high[0] - low_[0], high[1] - low_[1]};
  const auto count = static_cast<double>(discs.size());
  auto cellsAlong = static_cast<std::size_t>(std::sqrt(2.0 * count)) + 1;
  setCounts(cellsAlong, extent);
  while (cellsAlong > 1 && entriesOf(discs) > 32 * discs.size()) {
    cellsAlong /= 2;
    setCounts(cellsAlong, extent);
  }
  // count, then list
  begins_.assign(counts_[0] * counts_[1] + 1, 0);
  const auto forEachCell = [this](const Disc& disc, const auto& visit) {
    const Reach reach = reachOf(disc);
    for (std::size_t x = reach.first[0]; x <= reach.last[0]; ++x) {
      for (std::size_t z = reach.first[1]; z <= reach.last[1]; ++z) {
        visit(x * counts_[1] + z);
      }
    }
  };
  for (const Disc& disc : discs) {
    forEachCell(disc, [this](std::size_t cell) { ++begins_[cell + 1]; });
  }
  for (std::size_t cell = 1; cell < begins_.size(); ++cell) {
    begins_[cell] += begins_[cell - 1];
  }
  discs_.resize(begins_.back());
  std::vector<std::size_t> next = begins_;
  for (std::uint32_t i = 0; i < discs.size(); ++i) {
    forEachCell(discs[i], [&](std::size_t cell) { discs_[next[cell]++] = i; });
  }
}

void ZoneGrid::setCounts(std::size_t cellsAlong, const std::array<double, 2>& extent) {
  counts_ = {cellsAlong, cellsAlong};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    cellsPerLength_[axis] = static_cast<double>(cellsAlong) / extent[axis];
  }
}

ZoneGrid::Reach ZoneGrid::reachOf(const Disc& disc) const {
  const double wideX = widened(disc, disc.x);
  const double wideZ = widened(disc, disc.z);
  return {{cellOf(disc.x - wideX, 0), cellOf(disc.z - wideZ, 1)},
          {cellOf(disc.x + wideX, 0), cellOf(disc.z + wideZ, 1)}};
}

std::uint64_t ZoneGrid::entriesOf(std::span<const Disc> discs) const {
  std::uint64_t entries = 0;
  for (const Disc& disc : discs) {
    const Reach reach = reachOf(disc);
    entries += (reach.last[0] - reach.first[0] + 1) * (reach.last[1] - reach.first[1] + 1);
  }
  return entries;
}

}  // namespace espalier::environment

#include "engine/simulation/step/seed_bed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "engine/core/random.h"

namespace espalier::simulation {
namespace {

using core::Vec3;

// beyond the draws that environment processes make for a module
constexpr std::uint32_t kSettlingDraw = 1U << 20U;

/// Places in cells as wide as the spacing, so that only 27 cells can hold one that is too near.
class Places {
 public:
  Places(double spacing, std::size_t expectedCount) : spacing_(spacing) { cells_.reserve(expectedCount); }

  void add(const Vec3& place) {
    if (spacing_ > 0.0) {
      cells_[keyOf(cellOf(place))].push_back(place);
    }
  }

  [[nodiscard]] bool hasRoomAt(const Vec3& place) const {
    if (!(spacing_ > 0.0)) {
      return true;
    }
    const std::array<std::int64_t, 3> own = cellOf(place);
    for (std::int64_t i = -1; i <= 1; ++i) {
      for (std::int64_t j = -1; j <= 1; ++j) {
        for (std::int64_t k = -1; k <= 1; ++k) {
          const auto found = cells_.find(keyOf({own[0] + i, own[1] + j, own[2] + k}));
          if (found != cells_.end() && std::any_of(found->second.begin(), found->second.end(), [&](const Vec3& other) {
                return length(place - other) < spacing_;
              })) {
            return false;
          }
        }
      }
    }
    return true;
  }

 private:
  [[nodiscard]] std::array<std::int64_t, 3> cellOf(const Vec3& place) const {
    // far out all share the last cells: slower, and right
    const auto cell = [this](double x) {
      return static_cast<std::int64_t>(std::clamp(std::floor(x / spacing_), -1e15, 1e15));
    };
    return {cell(place.x), cell(place.y), cell(place.z)};
  }
  // cells that share a key only share a list: distances decide
  [[nodiscard]] static std::uint64_t keyOf(const std::array<std::int64_t, 3>& cell) {
    std::uint64_t key = 0;
    for (const std::int64_t c : cell) {
      key = (key ^ static_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15ULL;
      key ^= key >> 32U;
    }
    return key;
  }

  double spacing_;
  std::unordered_map<std::uint64_t, std::vector<Vec3>> cells_;
};

bool isInArea(const Vec3& place, const SeedRules& rules, const Vec3& up) {
  if (!rules.area) {
    return true;
  }
  const auto& [low, high] = *rules.area;
  const auto isBetween = [](double x, double a, double b, double alongUp) {
    return alongUp != 0.0 || (std::min(a, b) <= x && x <= std::max(a, b));
  };
  return isBetween(place.x, low.x, high.x, up.x) && isBetween(place.y, low.y, high.y, up.y) &&
         isBetween(place.z, low.z, high.z, up.z);
}

}  // namespace

void settleSeeds(std::vector<Seed>& seeds, const std::vector<Vec3>& places, const SeedRules& rules, const Vec3& up,
                 std::uint64_t runSeed, std::uint64_t step) {
  // to the ground
  for (Seed& seed : seeds) {
    seed.position = seed.position + up * (rules.ground - dot(seed.position, up));
    seed.hasTakenRoot = false;
  }
  // the order in which they settle
  using Turn = std::tuple<double, std::uint32_t, std::uint64_t, std::size_t>;
  std::vector<Turn> turns;
  turns.reserve(seeds.size());
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const core::CounterRandom random(runSeed, seeds[i].mother);
    const double draw =
        random.uniform(core::DrawDomain::Environment, static_cast<std::uint32_t>(step), seeds[i].module, kSettlingDraw);
    turns.emplace_back(draw, seeds[i].mother, seeds[i].module, i);
  }
  std::sort(turns.begin(), turns.end());
  // one after the other, as long as there is room
  Places taken(rules.spacing, places.size() + seeds.size());
  for (const Vec3& place : places) {
    taken.add(place);
  }
  std::uint64_t living = places.size();
  for (const Turn& turn : turns) {
    Seed& seed = seeds[std::get<3>(turn)];
    if (living >= rules.maximumPlants || !isInArea(seed.position, rules, up) || !taken.hasRoomAt(seed.position)) {
      continue;
    }
    seed.hasTakenRoot = true;
    taken.add(seed.position);
    ++living;
  }
}

}  // namespace espalier::simulation

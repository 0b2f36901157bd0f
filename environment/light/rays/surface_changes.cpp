#include "environment/light/rays/surface_changes.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace espalier::environment {

using core::Vec3;

namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double));

bool isSame(const LightSurfaces& a, std::uint32_t i, const LightSurfaces& b, std::uint32_t k) {
  for (std::size_t corner = 0; corner < 3; ++corner) {
    if (std::memcmp(&a.vertices[a.triangles[i][corner]], &b.vertices[b.triangles[k][corner]], sizeof(Vec3)) != 0) {
      return false;
    }
  }
  return a.seedOf(i) == b.seedOf(k) && a.thinningOf(i) == b.thinningOf(k) && (i < a.groundBegin) == (k < b.groundBegin);
}

std::uint64_t hashOf(const LightSurfaces& surfaces, std::uint32_t triangle) {
  std::uint64_t hash = surfaces.seedOf(triangle);
  for (const std::uint32_t corner : surfaces.triangles[triangle]) {
    std::array<std::uint64_t, 3> bits{};
    std::memcpy(bits.data(), &surfaces.vertices[corner], sizeof(bits));
    for (const std::uint64_t word : bits) {
      hash = (hash ^ word) * 0x9E3779B97F4A7C15ULL;
      hash ^= hash >> 32U;
    }
  }
  return hash;
}

void addTo(LightSurfaces& changed, const LightSurfaces& surfaces, std::uint32_t triangle) {
  const auto base = static_cast<std::uint32_t>(changed.vertices.size());
  for (const std::uint32_t corner : surfaces.triangles[triangle]) {
    changed.vertices.push_back(surfaces.vertices[corner]);
  }
  changed.triangles.push_back({base, base + 1, base + 2});
}

}  // namespace

SurfaceChanges changesBetween(const LightSurfaces& earlier, const LightSurfaces& later) {
  const auto earlierCount = static_cast<std::uint32_t>(earlier.triangles.size());
  const auto laterCount = static_cast<std::uint32_t>(later.triangles.size());
  SurfaceChanges changes;
  changes.earlierOf.assign(laterCount, SurfaceChanges::kNone);
  changes.laterOf.assign(earlierCount, SurfaceChanges::kNone);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> byHash;  // of the earlier ones; made when it is needed
  std::uint32_t next = 0;                                       // the first of the earlier ones that may be met
  for (std::uint32_t triangle = 0; triangle < laterCount; ++triangle) {
    std::uint32_t found = SurfaceChanges::kNone;
    if (next < earlierCount && isSame(later, triangle, earlier, next)) {
      found = next;
    } else if (next < earlierCount) {
      if (byHash.empty()) {
        for (std::uint32_t i = next; i < earlierCount; ++i) {
          byHash.emplace_back(hashOf(earlier, i), i);
        }
        std::sort(byHash.begin(), byHash.end());
      }
      const std::uint64_t hash = hashOf(later, triangle);
      for (auto entry = std::lower_bound(byHash.begin(), byHash.end(), std::pair(hash, next));
           entry != byHash.end() && entry->first == hash; ++entry) {
        if (isSame(later, triangle, earlier, entry->second)) {
          found = entry->second;
          break;
        }
      }
    }
    if (found == SurfaceChanges::kNone) {
      addTo(changes.changed, later, triangle);
      continue;
    }
    changes.earlierOf[triangle] = found;
    changes.laterOf[found] = triangle;
    next = found + 1;
  }
  for (std::uint32_t i = 0; i < earlierCount; ++i) {
    if (changes.laterOf[i] == SurfaceChanges::kNone) {
      addTo(changes.changed, earlier, i);
    }
  }
  return changes;
}

}  // namespace espalier::environment

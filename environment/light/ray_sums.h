#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/core/work_meter.h"
#include "environment/geometry/sphere_columns.h"
#include "environment/geometry/sphere_tree.h"

namespace espalier::environment {

/// Sums over the spheres that each of many rays meets, kept from one set of spheres to the next. Amounts are whole
/// numbers, so a sum does not depend on the order of its parts. When few spheres came or went, only these are searched
/// along the kept rays. The sums are bitwise those of a new beginning.
class RaySums {
 public:
  /// Stands for a sum that is beyond the limit.
  static constexpr std::int64_t kBeyond = std::numeric_limits<std::int64_t>::max();
  /// Largest limit.
  static constexpr std::int64_t kMostLimit = std::int64_t{1} << 62;

  /// The rays, and the term that a sphere adds; the same from one update to the next.
  template <typename RayOf, typename MarginOf, typename AmountOf>
  struct Rays {
    std::size_t count;   // from every sphere
    std::int64_t limit;  // 0 … kMostLimit; a sum beyond it is kBeyond
    RayOf rayOf;         // (sphere, k) → Ray
    MarginOf marginOf;   // (sphere) → by how much boxes of spheres are enlarged for its rays
    AmountOf amountOf;  // (own, other, ray) → whole number, at least 0; other spheres with the same numbers count, too
    bool areParallel = false;  // the k-th rays of all spheres: they are looked up in columns when all are asked for
  };

  template <typename RayOf, typename MarginOf, typename AmountOf>
  Rays(std::size_t, std::int64_t, RayOf, MarginOf, AmountOf, bool = false) -> Rays<RayOf, MarginOf, AmountOf>;

  /// Calls `visit(index, sums)` for every sphere of `now` with the sums along its rays (std::span, by ray). O(n · rays
  /// · (log n + spheres met)); when c spheres came or went since the last update, O(n log n + n · rays · (log c +
  /// changed spheres met) + c · rays · (log n + spheres met)).
  /// Throws WorkStopped; the kept sums are as before then.
  template <typename RayOf, typename MarginOf, typename AmountOf, typename Visit>
  void update(const DistinctSpheres& now, const Rays<RayOf, MarginOf, AmountOf>& rays, const Visit& visit);
  /// Forgets all sums. Call it before an update with other `rays`.
  void clear();

 private:
  static constexpr std::uint32_t kNew = 0xFFFFFFFFU;
  static constexpr std::size_t kMostKept = std::size_t{1} << 25;  // sums: 256 MB
  static constexpr std::size_t kFewChanges = 4;                   // fewer than one of so many spheres

  struct Change {
    std::vector<Sphere> spheres;        // whose number is another than before
    std::vector<std::int64_t> more;     // by how many, negative: fewer
    std::vector<std::uint32_t> before;  // index before, by sphere of `now`; kNew: it was not there
  };
  [[nodiscard]] std::optional<Change> changeTo(const DistinctSpheres& now) const;

  /// amount · times, or kBeyond.
  static std::int64_t product(std::int64_t amount, std::int64_t times, std::int64_t limit) {
    return amount > 0 && times > limit / amount ? kBeyond : amount * times;
  }
  /// The sum along a ray of a sphere. `search` calls its argument for all spheres that the ray may meet.
  template <typename AnyRays, typename Search>
  static std::int64_t sumOver(const DistinctSpheres& now, const AnyRays& rays, std::uint32_t index, const Ray& ray,
                              const Search& search);
  /// The sums of all spheres, one direction after the other. Returns for which rays there are any: for the others the
  /// spheres are too different for columns.
  template <typename AnyRays>
  static std::vector<bool> sumByColumns(const DistinctSpheres& now, const AnyRays& rays,
                                        std::vector<std::int64_t>& sums);

  DistinctSpheres last_;
  std::vector<std::int64_t> sums_;  // by sphere of last_ and ray; empty: nothing is kept
};

template <typename AnyRays, typename Search>
std::int64_t RaySums::sumOver(const DistinctSpheres& now, const AnyRays& rays, std::uint32_t index, const Ray& ray,
                              const Search& search) {
  const Sphere& own = now.spheres[index];
  std::int64_t sum = 0;
  search([&](std::uint32_t other, const Sphere& sphere) {
    const std::int64_t times = static_cast<std::int64_t>(now.count[other]) - (other == index ? 1 : 0);
    const std::int64_t part = times > 0 ? product(rays.amountOf(own, sphere, ray), times, rays.limit) : 0;
    sum = part == kBeyond || sum + part > rays.limit ? kBeyond : sum + part;
    return sum != kBeyond;
  });
  return sum;
}

template <typename AnyRays>
std::vector<bool> RaySums::sumByColumns(const DistinctSpheres& now, const AnyRays& rays,
                                        std::vector<std::int64_t>& sums) {
  std::vector<bool> areSummed(rays.count, now.spheres.empty());
  double margin = 0.0;
  for (const Sphere& own : now.spheres) {
    margin = std::max(margin, rays.marginOf(own));
  }
  for (std::size_t k = 0; k < rays.count && !now.spheres.empty(); ++k) {
    const SphereColumns columns(now.spheres, rays.rayOf(now.spheres.front(), k).direction, margin);
    areSummed[k] = columns.isMade();
    for (std::uint32_t index = 0; columns.isMade() && index < now.spheres.size(); ++index) {
      core::pollWork();
      const Ray ray = rays.rayOf(now.spheres[index], k);
      sums[index * rays.count + k] =
          sumOver(now, rays, index, ray, [&](const auto& add) { columns.visit(ray.origin, add); });
    }
  }
  return areSummed;
}

template <typename RayOf, typename MarginOf, typename AmountOf, typename Visit>
void RaySums::update(const DistinctSpheres& now, const Rays<RayOf, MarginOf, AmountOf>& rays, const Visit& visit) {
  const std::size_t count = now.spheres.size();
  const auto change = sums_.size() == last_.spheres.size() * rays.count ? changeTo(now) : std::nullopt;
  const bool isKept = count <= kMostKept / rays.count;
  const SphereTree changed(change ? change->spheres : std::vector<Sphere>{});
  std::vector<std::int64_t> next(isKept ? count * rays.count : rays.count);
  const std::vector<bool> areSummed =
      rays.areParallel && isKept && !change ? sumByColumns(now, rays, next) : std::vector<bool>(rays.count, false);
  std::optional<SphereTree> tree;
  if (std::ranges::find(areSummed, false) != areSummed.end()) {
    tree.emplace(now.spheres);
  }

  const auto sumAnew = [&](std::uint32_t index, const Ray& ray, double margin) {
    return sumOver(now, rays, index, ray, [&](const auto& add) { tree->visitRay(ray, margin, add); });
  };
  // nothing: a sphere is gone from a sum that was beyond the limit, so the new sum is unknown
  const auto sumChanged = [&](std::int64_t before, const Sphere& own, const Ray& ray,
                              double margin) -> std::optional<std::int64_t> {
    std::int64_t added = 0;
    std::int64_t removed = 0;
    changed.visitRay(ray, margin, [&](std::uint32_t other, const Sphere& sphere) {
      const std::int64_t amount = rays.amountOf(own, sphere, ray);
      const std::int64_t more = change->more[other];
      if (amount > 0 && more < 0) {
        removed = before == kBeyond ? kBeyond : removed - amount * more;
      } else if (amount > 0 && added != kBeyond) {
        const std::int64_t part = product(amount, more, rays.limit);
        added = part == kBeyond || added + part > rays.limit ? kBeyond : added + part;
      }
      return removed != kBeyond;
    });
    if (removed == kBeyond) {
      return std::nullopt;
    }
    if (before == kBeyond || added == kBeyond) {
      return kBeyond;
    }
    const std::int64_t sum = before - removed + added;
    return sum > rays.limit ? kBeyond : sum;
  };

  const auto sumAll = [&](std::uint32_t index) {
    core::pollWork();
    const Sphere& own = now.spheres[index];
    const double margin = rays.marginOf(own);
    const std::uint32_t before = change ? change->before[index] : kNew;
    std::int64_t* sums = next.data() + (isKept ? index * rays.count : 0);
    for (std::size_t k = 0; k < rays.count; ++k) {
      if (areSummed[k]) {
        continue;
      }
      const Ray ray = rays.rayOf(own, k);
      const auto kept = before == kNew ? std::nullopt : sumChanged(sums_[before * rays.count + k], own, ray, margin);
      sums[k] = kept ? *kept : sumAnew(index, ray, margin);
    }
    visit(index, std::span<const std::int64_t>(sums, rays.count));
  };
  if (!tree) {
    for (std::uint32_t index = 0; index < count; ++index) {
      sumAll(index);
    }
  } else {
    // neighbours one after the other
    std::ranges::for_each(tree->order(), sumAll);
  }
  if (!isKept) {
    clear();
    return;
  }
  last_ = now;
  sums_ = std::move(next);
}

}  // namespace espalier::environment

#include "environment/light/ray_sums.h"

#include <tuple>

namespace espalier::environment {

void RaySums::clear() {
  last_ = {};
  sums_.clear();
}

std::optional<RaySums::Change> RaySums::changeTo(const DistinctSpheres& now) const {
  // both are sorted
  Change change;
  change.before.assign(now.spheres.size(), kNew);
  std::size_t before = 0;
  std::size_t after = 0;
  while (before < last_.spheres.size() || after < now.spheres.size()) {
    const bool isGone =
        after == now.spheres.size() ||
        (before < last_.spheres.size() && orderKeyOf(last_.spheres[before]) < orderKeyOf(now.spheres[after]));
    const bool isNew = !isGone && (before == last_.spheres.size() ||
                                   orderKeyOf(now.spheres[after]) < orderKeyOf(last_.spheres[before]));
    std::int64_t more = 0;
    if (!isNew) {
      more -= last_.count[before];
    }
    if (!isGone) {
      more += now.count[after];
    }
    if (more != 0) {
      change.spheres.push_back(isGone ? last_.spheres[before] : now.spheres[after]);
      change.more.push_back(more);
    }
    if (!isNew && !isGone) {
      change.before[after] = static_cast<std::uint32_t>(before);
    }
    before += isNew ? 0 : 1;
    after += isGone ? 0 : 1;
    if (change.spheres.size() * kFewChanges > now.spheres.size()) {
      return std::nullopt;
    }
  }
  return change;
}

}  // namespace espalier::environment

#include "engine/simulation/step/production_log.h"

#include <algorithm>

namespace espalier::simulation {
namespace {

// more steps than a person goes back to
constexpr std::size_t kMostSteps = 1000;
// productions in all of these steps: a model may have many
constexpr std::uint64_t kMostUses = 65536;
// of a production in one step, about
constexpr std::uint64_t kUseBytes = 64;

}  // namespace

void ProductionLog::follow(bool isWanted, std::uint64_t completedSteps) {
  isFollowed_ = isWanted;
  beginAt(completedSteps);
}

void ProductionLog::beginAt(std::uint64_t step) {
  auto none = std::make_shared<ProductionUses>();
  none->since = step;
  none->step = step;
  useCount_ = 0;
  steps_.assign(1, none);
  present_ = std::move(none);
}

void ProductionLog::complete(std::uint64_t step) {
  auto next = std::make_shared<ProductionUses>(*present_);
  next->step = step;
  for (auto& [production, use] : next->uses) {
    use.last = 0;
  }
  for (const derivation::ProductionCounts& counts : counts_) {
    for (const auto& [production, count] : counts) {
      ProductionUse& use = next->uses[production];
      use.last += count;
      use.total += count;
    }
  }
  while (!steps_.empty() && steps_.back()->step >= step) {
    useCount_ -= steps_.back()->uses.size();
    steps_.pop_back();
  }
  useCount_ += next->uses.size();
  while (!steps_.empty() && (steps_.size() == kMostSteps || useCount_ > kMostUses)) {
    useCount_ -= steps_.front()->uses.size();
    steps_.pop_front();
  }
  steps_.push_back(next);
  present_ = std::move(next);
}

std::uint64_t ProductionLog::bytes() const {
  return useCount_ * kUseBytes;
}

void ProductionLog::goTo(std::uint64_t step) {
  if (!isFollowed_) {
    return;
  }
  const auto known = std::find_if(steps_.begin(), steps_.end(), [&](const auto& uses) { return uses->step == step; });
  if (known == steps_.end()) {
    beginAt(step);
  } else {
    present_ = *known;
  }
}

}  // namespace espalier::simulation

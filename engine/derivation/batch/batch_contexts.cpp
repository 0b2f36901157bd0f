// The sites whose predecessors and contexts match.
#include <algorithm>
#include <cstring>

#include "engine/derivation/batch/batch_rewriter.h"
#include "engine/derivation/matching/context_walk.h"

namespace espalier::derivation {

using core::ModuleTypeId;

std::size_t BatchRewriter::match(const BatchRule& rule, std::span<const std::uint32_t> sites) {
  std::size_t lane = laneCount_;
  switch (rule.context) {
    case BatchRule::Context::None:
      std::memcpy(laneSite_.data() + lane, sites.data(), sites.size_bytes());
      lane += sites.size();
      break;
    case BatchRule::Context::Near:
      if (rule.right == core::kNoModuleType) {
        lane = matchNear<true, false>(rule, sites);
      } else if (rule.left == core::kNoModuleType) {
        lane = matchNear<false, true>(rule, sites);
      } else {
        lane = matchNear<true, true>(rule, sites);
      }
      break;
    case BatchRule::Context::Searched:
      return matchSearched(rule, sites);
  }
  return lane - laneCount_;
}

template <bool kLooksLeft, bool kLooksRight>
std::size_t BatchRewriter::matchNear(const BatchRule& rule, std::span<const std::uint32_t> sites) {
  std::uint32_t* const laneSite = laneSite_.data();
  std::uint64_t* const laneLeft = laneLeft_.data();
  std::uint64_t* const laneRight = laneRight_.data();
  const ModuleTypeId* const leftType = leftType_.data();
  const ModuleTypeId* const rightType = rightType_.data();
  const std::uint64_t* const leftOffset = leftOffset_.data();
  const std::uint64_t* const rightOffset = rightOffset_.data();
  const ModuleTypeId left = rule.left;
  const ModuleTypeId right = rule.right;
  std::size_t lane = laneCount_;
  for (const std::uint32_t site : sites) {
    laneSite[lane] = site;
    bool isMatch = true;
    if constexpr (kLooksLeft) {
      laneLeft[lane] = leftOffset[site];
      isMatch = leftType[site] == left;
    }
    if constexpr (kLooksRight) {
      laneRight[lane] = rightOffset[site];
      isMatch = isMatch & (rightType[site] == right);
    }
    lane += isMatch ? 1 : 0;
  }
  return lane;
}

/// The nearest neighbours, which are the same for all rules.
void BatchRewriter::findNeighbours(const BatchGroup& group, std::span<const std::uint32_t> sites) {
  if (group.looksLeft) {
    group.keepsModules ? findLeft<true>(sites) : findLeft<false>(sites);
  }
  if (group.looksRight) {
    group.keepsModules ? findRight<true>(sites) : findRight<false>(sites);
  }
}

template <bool kKeepsModules>
void BatchRewriter::findLeft(std::span<const std::uint32_t> sites) {
  const LeftWalk<false> walk(*program_, *rules_, step_.old);
  const std::uint32_t* const siteModule = siteModule_.data();
  const std::uint32_t* const siteOffset = siteOffset_.data();
  ModuleTypeId* const leftType = leftType_.data();
  std::uint64_t* const leftOffset = leftOffset_.data();
  [[maybe_unused]] std::uint64_t* const leftModule = leftModule_.data();
  const std::uint64_t first = first_;
  const std::uint64_t firstOffset = offset_;
  for (const std::uint32_t site : sites) {
    SearchShortcuts::Place place{first + siteModule[site], firstOffset + siteOffset[site]};
    leftType[site] = walk.to(place);
    leftOffset[site] = place.offset;
    if constexpr (kKeepsModules) {
      leftModule[site] = place.module;
    }
  }
}

template <bool kKeepsModules>
void BatchRewriter::findRight(std::span<const std::uint32_t> sites) {
  const ContextString& old = step_.old;
  const RightWalk<false> walk(*program_, *rules_, SearchKind::Right, old);
  const std::uint16_t* arity = program_->arity.data();
  const std::uint32_t* const siteModule = siteModule_.data();
  const std::uint32_t* const siteOffset = siteOffset_.data();
  ModuleTypeId* const rightType = rightType_.data();
  std::uint64_t* const rightOffset = rightOffset_.data();
  [[maybe_unused]] std::uint64_t* const rightModule = rightModule_.data();
  const std::uint64_t first = first_;
  const std::uint64_t firstOffset = offset_;
  for (const std::uint32_t site : sites) {
    const std::uint64_t module = first + siteModule[site];
    SearchShortcuts::Place place{module + 1, firstOffset + siteOffset[site] + arity[old.types[module]]};
    rightType[site] = walk.to(place);
    rightOffset[site] = place.offset;
    if constexpr (kKeepsModules) {
      rightModule[site] = place.module;
    }
  }
}

std::size_t BatchRewriter::matchSearched(const BatchRule& rule, std::span<const std::uint32_t> sites) {
  std::uint32_t* const laneSite = laneSite_.data() + laneCount_;
  std::uint64_t* const laneRow = laneLeft_.data() + laneCount_;
  if (rule.sharesPlaces) {
    std::size_t count = 0;
    for (const std::uint32_t site : sites) {
      laneSite[count] = site;
      laneRow[count] = siteRow_[site];
      count += siteRow_[site] != kNoRow ? 1 : 0;
    }
    return count;
  }
  const language::Production& production = *rule.production;
  const std::size_t leftCount = production.leftContext.size();
  const std::size_t rowSize = leftCount + production.rightContext.size();
  const std::size_t length = production.predecessor.size();
  const std::uint32_t ownParameters = plan_->blocks()[rule.block].readParameters;
  const std::uint32_t* const siteModule = siteModule_.data();
  const std::uint32_t* const siteOffset = siteOffset_.data();
  const std::uint8_t* const siteBits = siteBits_.data();
  const std::uint64_t first = first_;
  const std::uint64_t firstOffset = offset_;
  // the modules where the predecessor stands, and the nearest neighbours that are known
  const bool startsLeft = rule.startsLeft;
  const bool startsRight = rule.startsRight;
  const ModuleTypeId left = startsLeft ? production.leftContext[0].module.type : core::kNoModuleType;
  const ModuleTypeId right = startsRight ? production.rightContext[0].module.type : core::kNoModuleType;
  const ModuleTypeId* const leftType = leftType_.data();
  const ModuleTypeId* const rightType = rightType_.data();
  std::size_t count = 0;
  for (const std::uint32_t site : sites) {
    laneSite[count] = site;
    const bool isNearLeft = !startsLeft || leftType[site] == left;
    const bool isNearRight = !startsRight || rightType[site] == right;
    count += (((siteBits[site] & rule.mark) != 0) & isNearLeft & isNearRight) ? 1 : 0;
  }
  if (length > 1) {
    const auto end = std::remove_if(laneSite, laneSite + count, [&](std::uint32_t site) {
      return !standsAt(production, first + siteModule[site]);
    });
    count = static_cast<std::size_t>(end - laneSite);
  }
  contexts_.begin(count, rowSize);
  const std::size_t firstRow = rowsUsed_;
  rowsUsed_ += count * rowSize;
  rows_.resize(std::max(rows_.size(), rowsUsed_));
  std::uint64_t* const rows = rows_.data() + firstRow;
  // the contexts
  const std::span<const language::ContextElement> rightContext = production.rightContext;
  if (startsRight) {
    const std::uint64_t behind = program_->arity[right];
    const std::uint64_t* const rightOffset = rightOffset_.data();
    const std::uint64_t* const rightModule = rightModule_.data();
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t site = laneSite[i];
      rows[i * rowSize + leftCount] = rightOffset[site];
      contexts_.move(i, rightModule[site] + 1, rightOffset[site] + behind);
    }
    contexts_.findRight(step_.old, rightContext.subspan(1), leftCount + 1, rows);
  } else if (!rightContext.empty()) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t site = laneSite[i];
      contexts_.move(i, first + siteModule[site] + length, firstOffset + siteOffset[site] + ownParameters);
    }
    contexts_.findRight(step_.old, rightContext, leftCount, rows);
  }
  const std::span<const language::ContextElement> leftContext = production.leftContext;
  if (startsLeft) {
    for (const std::uint32_t search : contexts_.found()) {
      const std::uint32_t site = laneSite[search];
      rows[search * rowSize] = leftOffset_[site];
      contexts_.move(search, leftModule_[site], leftOffset_[site]);
    }
    contexts_.findLeft(step_.old, leftContext.subspan(1), 1, rows);
  } else if (!leftContext.empty()) {
    for (const std::uint32_t search : contexts_.found()) {
      const std::uint32_t site = laneSite[search];
      contexts_.move(search, first + siteModule[site], firstOffset + siteOffset[site]);
    }
    contexts_.findLeft(step_.old, leftContext, 0, rows);
  }
  if (rule.keepsPlaces) {
    std::uint64_t* const siteRow = siteRow_.data();
    for (const std::uint32_t site : sites) {
      siteRow[site] = kNoRow;
    }
    for (const std::uint32_t search : contexts_.found()) {
      siteRow[laneSite[search]] = firstRow + search * rowSize;
    }
  }
  std::size_t lane = 0;
  for (const std::uint32_t search : contexts_.found()) {
    laneSite[lane] = laneSite[search];
    laneRow[lane] = firstRow + search * rowSize;
    ++lane;
  }
  return lane;
}

bool BatchRewriter::standsAt(const language::Production& production, std::uint64_t module) const {
  const ModuleTypeId* const types = step_.old.types + module;
  const std::size_t length = production.predecessor.size();
  if (step_.old.size - module < length) {
    return false;
  }
  for (std::size_t i = 1; i < length; ++i) {
    if (types[i] != production.predecessor[i].type) {
      return false;
    }
  }
  return true;
}

}  // namespace espalier::derivation

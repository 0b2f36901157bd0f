// The sites whose predecessors and contexts match.
#include <algorithm>
#include <cstring>

#include "engine/derivation/batch/batch_rewriter.h"

namespace espalier::derivation {

using core::ModuleTypeId;

std::size_t BatchRewriter::match(const BatchRule& rule, std::uint8_t bit, std::span<const std::uint32_t> sites) {
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
      return matchSearched(rule, bit, sites);
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

void BatchRewriter::findLeft(std::span<const std::uint32_t> sites) {
  const ContextString old = step_.old;
  const std::uint16_t* arity = program_->arity.data();
  const std::uint8_t* passing = passing_.data();
  const std::uint32_t* const siteModule = siteModule_.data();
  const std::uint32_t* const siteOffset = siteOffset_.data();
  ModuleTypeId* const leftType = leftType_.data();
  std::uint64_t* const leftOffset = leftOffset_.data();
  const std::uint64_t first = first_;
  const std::uint64_t firstOffset = offset_;
  const ModuleTypeId openBranch = program_->openBranch;
  for (const std::uint32_t site : sites) {
    std::uint64_t module = first + siteModule[site];
    std::uint64_t offset = firstOffset + siteOffset[site];
    ModuleTypeId found = core::kNoModuleType;
    std::uint32_t passed = 0;
    while (module > 0) {
      --module;
      const ModuleTypeId type = old.types[module];
      offset -= arity[type];
      if ((passing[type] & (kSkippedLeft | kJumpedLeft)) == 0) [[likely]] {
        found = type;
        break;
      }
      if ((passing[type] & kJumpedLeft) != 0) {
        const StringIndex::Link& link = old.index->link(module);
        if (link.partner == StringIndex::kNone) {
          break;
        }
        module = link.partner;
        offset -= link.parameterCount;
      }
      // all searches together walk a long way over branches once
      if (++passed > LeftShortcuts::kNearModules && old.types[module] == openBranch) [[unlikely]] {
        const LeftShortcuts::Place end = old.shortcuts->follow(*program_, *rules_, old, {module, offset});
        module = end.module;
        offset = end.offset;
        passed = 0;
      }
    }
    leftType[site] = found;
    leftOffset[site] = offset;
  }
}

void BatchRewriter::findRight(std::span<const std::uint32_t> sites) {
  const ContextString old = step_.old;
  const std::uint16_t* arity = program_->arity.data();
  const std::uint8_t* passing = passing_.data();
  const std::uint32_t* const siteModule = siteModule_.data();
  const std::uint32_t* const siteOffset = siteOffset_.data();
  ModuleTypeId* const rightType = rightType_.data();
  std::uint64_t* const rightOffset = rightOffset_.data();
  const std::uint64_t first = first_;
  const std::uint64_t firstOffset = offset_;
  for (const std::uint32_t site : sites) {
    std::uint64_t module = first + siteModule[site];
    std::uint64_t offset = firstOffset + siteOffset[site] + arity[old.types[module]];
    ModuleTypeId found = core::kNoModuleType;
    ++module;
    while (module < old.size) {
      const ModuleTypeId type = old.types[module];
      if ((passing[type] & (kSkippedRight | kJumpedRight)) == 0) [[likely]] {
        found = type;
        break;
      }
      if ((passing[type] & kSkippedRight) != 0) {
        offset += arity[type];
        ++module;
      } else {
        const StringIndex::Link& link = old.index->link(module);
        if (link.partner == StringIndex::kNone) {
          break;
        }
        module = link.partner + std::uint64_t{1};
        offset += link.parameterCount;
      }
    }
    rightType[site] = found;
    rightOffset[site] = offset;
  }
}

std::size_t BatchRewriter::matchSearched(const BatchRule& rule, std::uint8_t bit,
                                         std::span<const std::uint32_t> sites) {
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
  // the modules where the predecessor stands
  std::size_t count = 0;
  for (const std::uint32_t site : sites) {
    const std::uint64_t module = first_ + siteModule[site];
    laneSite[count] = site;
    count += (siteBits[site] & bit) != 0 && (length == 1 || standsAt(production, module)) ? 1 : 0;
  }
  contexts_.begin(count, rowSize);
  for (std::uint32_t i = 0; i < count; ++i) {
    contexts_.move(i, first_ + siteModule[laneSite[i]] + length, offset_ + siteOffset[laneSite[i]] + ownParameters);
  }
  // the contexts
  const std::size_t firstRow = rowsUsed_;
  rowsUsed_ += count * rowSize;
  rows_.resize(std::max(rows_.size(), rowsUsed_));
  contexts_.findRight(step_.old, production.rightContext, leftCount, rows_.data() + firstRow);
  if (leftCount > 0) {
    for (const std::uint32_t search : contexts_.found()) {
      contexts_.move(search, first_ + siteModule[laneSite[search]], offset_ + siteOffset[laneSite[search]]);
    }
    contexts_.findLeft(step_.old, production.leftContext, 0, rows_.data() + firstRow);
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

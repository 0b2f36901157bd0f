#include "engine/derivation/batch/batch_rewriter.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <utility>

#include "engine/core/check.h"
#include "engine/derivation/matching/production_plan.h"

namespace espalier::derivation {
namespace {

using core::ModuleTypeId;

/// The effect of a module on context searches, as bits.
constexpr std::uint8_t kSkippedLeft = 1;   // passed by a search to the left
constexpr std::uint8_t kSkippedRight = 2;  // passed by a search to the right
constexpr std::uint8_t kJumpedLeft = 4;    // `]`: the branch is passed
constexpr std::uint8_t kJumpedRight = 8;   // `[`

/// One number of each module type's plan, by type.
std::vector<std::uint32_t> byType(const ProductionPlan& productions, std::size_t typeCount,
                                  std::uint32_t (*number)(const TypePlan&)) {
  std::vector<std::uint32_t> numbers(typeCount);
  for (std::size_t type = 0; type < typeCount; ++type) {
    numbers[type] = number(productions[static_cast<ModuleTypeId>(type)]);
  }
  return numbers;
}

}  // namespace

BatchRewriter::BatchRewriter(const language::Program& program, const ContextRules& rules, const BatchPlan& plan,
                             const ProductionPlan& productions)
    : program_(&program),
      rules_(&rules),
      plan_(&plan),
      productions_(&productions),
      evaluator_(program, plan.largestSlotCount(), plan.largestColumnCount()),
      finder_(program.arity, plan.siteMarks()),
      fixedModuleSum_(byType(productions, program.moduleTypeCount(), [](const TypePlan& made) { return made.length; })),
      fixedParameterSum_(byType(productions, program.moduleTypeCount(),
                                [](const TypePlan& made) { return std::uint32_t{made.copied}; })),
      parameterSum_({program.arity.begin(), program.arity.end()}),
      passing_(program.moduleTypeCount(), 0),
      siteModule_(kChunkModules + ModuleFinder::kSlack),
      siteOffset_(kChunkModules + ModuleFinder::kSlack),
      siteBits_(kChunkModules + ModuleFinder::kSlack),
      siteBlock_(kChunkModules),
      madeModule_(kChunkModules),
      madeOffset_(kChunkModules),
      resizing_(kChunkModules + 1),
      allSites_(kChunkModules),
      sorted_(kChunkModules),
      groupOf_(program.moduleTypeCount(), 0),
      siteGroup_(kChunkModules),
      groupCounts_(2 * (plan.groups().size() + 2)),
      groupBegin_(plan.groups().size() + 1),
      remaining_(kChunkModules),
      laneSite_(2 * kChunkModules),
      laneLeft_(2 * kChunkModules),
      laneRight_(2 * kChunkModules),
      leftType_(kChunkModules),
      rightType_(kChunkModules),
      leftOffset_(kChunkModules),
      rightOffset_(kChunkModules),
      keptLocals_(2 * kChunkModules * plan.largestKeptCount()),
      own_(ColumnEvaluator::kLanes),
      modules_(ColumnEvaluator::kLanes),
      words_(kChunkModules + 8),
      positions_(kChunkModules) {
  std::iota(allSites_.begin(), allSites_.end(), 0U);
  for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
    const auto type = static_cast<ModuleTypeId>(i);
    switch (plan.classOf(type)) {
      case BatchPlan::Class::Group:
        groupOf_[type] = plan.indexOf(type);
        break;
      case BatchPlan::Class::Fixed:
        groupOf_[type] = static_cast<std::uint32_t>(plan.groups().size());
        break;
      case BatchPlan::Class::General:
        groupOf_[type] = static_cast<std::uint32_t>(plan.groups().size() + 1);
        break;
      case BatchPlan::Class::Kept:
        break;
    }
    if (type == program.closeBranch) {
      passing_[type] = static_cast<std::uint8_t>(kJumpedLeft | (rules.isIgnored(type) ? kSkippedRight : 0));
    } else if (type == program.openBranch) {
      passing_[type] = static_cast<std::uint8_t>(kSkippedLeft | (rules.isIgnored(type) ? kSkippedRight : kJumpedRight));
    } else if (rules.isIgnored(type)) {
      passing_[type] = kSkippedLeft | kSkippedRight;
    }
  }
}

void BatchRewriter::begin(const Step& step) {
  step_ = step;
  if (step_.old.shortcuts == nullptr) {
    shortcuts_.clear();
    step_.old.shortcuts = &shortcuts_;
  }
  evaluator_.begin(step.inputs);
}

BatchRewriter::Outcome BatchRewriter::choose(std::uint64_t first, std::uint64_t end, std::uint64_t offset) {
  first_ = first;
  end_ = end;
  offset_ = offset;
  isUnusual_ = false;
  isResized_ = false;
  isChanged_ = false;
  areDrawsLoaded_ = false;
  lightSites_ = 0;
  laneCount_ = 0;
  resizingCount_ = 0;
  rowsUsed_ = 0;
  ruleLanes_.clear();
  stores_.clear();
  evaluator_.clearUnusual();
  if (plan_->isFixedOnly()) {
    return countFixed();
  }

  collectSites();
  if (plan_->hasOneKindOnly()) {
    std::fill_n(siteBlock_.begin(), siteCount_, 0U);
    if (siteCount_ > 0) {
      chooseGroup(plan_->groups().front(), {allSites_.data(), siteCount_});
    }
  } else {
    sortSites();
    // fixed blocks follow the groups
    lightSites_ = siteCount_ - groupBegin_.back();
    for (std::size_t i = 0; i < plan_->groups().size(); ++i) {
      if (groupBegin_[i] != groupBegin_[i + 1]) {
        chooseGroup(plan_->groups()[i], {sorted_.data() + groupBegin_[i], groupBegin_[i + 1] - groupBegin_[i]});
      }
    }
  }

  if (plan_->hasLongPredecessors()) {
    dropOverlapped();
  }
  Outcome outcome{end_,
                  endOffset_,
                  end_ - first_,
                  endOffset_ - offset_,
                  isUnusual_ || evaluator_.isUnusual(),
                  lightSites_,
                  isChanged_ || isResized_};
  if (isResized_) {
    place();
    outcome.moduleCount = madeModules_;
    outcome.parameterCount = madeParameters_;
  }
  return outcome;
}

BatchRewriter::Outcome BatchRewriter::countFixed() {
  const ModuleTypeId* types = step_.old.types + first_;
  fixedModules_ = fixedModuleSum_.of(types, end_ - first_);
  fixedParameters_ = fixedParameterSum_.of(types, end_ - first_);
  endOffset_ = offset_ + parameterSum_.of(types, end_ - first_);
  return {end_, endOffset_, fixedModules_, fixedParameters_, false};
}

void BatchRewriter::writeFixed(ModuleTypeId* types, double* parameters) const {
  ModuleTypeId* const end = types + fixedModules_;
  if (plan_->fixedBlocks().hasTable()) {
    plan_->fixedBlocks().write(step_.old.types + first_, end_ - first_, types, end);
    return;
  }
  const TypePlan* plans = productions_->plans();
  const double* oldParameters = step_.old.parameters + offset_;
  for (std::uint64_t module = first_; module < end_; ++module) {
    const TypePlan& plan = plans[step_.old.types[module]];
    // written whole while there is room, however many modules count
    if (end - types >= static_cast<std::ptrdiff_t>(TypePlan::kInlineTypes)) [[likely]] {
      std::memcpy(types, plan.types.data(), sizeof(plan.types));
      if (plan.length > TypePlan::kInlineTypes) [[unlikely]] {
        std::memcpy(types, productions_->types() + plan.firstType, plan.length * sizeof(ModuleTypeId));
      }
    } else {
      std::memcpy(types, productions_->types() + plan.firstType, plan.length * sizeof(ModuleTypeId));
    }
    types += plan.length;
    if (plan.copied > 0) {
      std::memcpy(parameters, oldParameters, plan.copied * sizeof(double));
      parameters += plan.copied;
    }
    oldParameters += plan.arity;
  }
}

void BatchRewriter::collectSites() {
  const ModuleFinder::Count count =
      finder_.find(step_.old.types + first_, static_cast<std::uint32_t>(end_ - first_), first_ > 0,
                   end_ < step_.old.size, {siteModule_.data(), siteOffset_.data(), siteBits_.data()});
  siteCount_ = count.found;
  endOffset_ = offset_ + count.parameters;
  if (plan_->needsPairBits()) {
    dropPairs();
  }
}

void BatchRewriter::dropPairs() {
  const ModuleTypeId* types = step_.old.types;
  const std::uint8_t* leftBits = plan_->leftBits();
  const std::uint8_t* rightBits = plan_->rightBits();
  const std::size_t stride = plan_->pairStride();
  // beyond the ends of the string every type is possible
  const auto unknown = static_cast<std::size_t>(program_->moduleTypeCount());
  std::size_t kept = 0;
  for (std::size_t site = 0; site < siteCount_; ++site) {
    const std::uint64_t module = first_ + siteModule_[site];
    const std::size_t type = types[module];
    const std::size_t before = module == 0 ? unknown : types[module - 1];
    const std::size_t behind = module + 1 == step_.old.size ? unknown : types[module + 1];
    const auto bits = static_cast<std::uint8_t>(leftBits[before * stride + type] & rightBits[type * stride + behind]);
    siteModule_[kept] = siteModule_[site];
    siteOffset_[kept] = siteOffset_[site];
    siteBits_[kept] = bits;
    kept += bits != 0 ? 1 : 0;
  }
  siteCount_ = kept;
}

void BatchRewriter::sortSites() {
  // local pointers: to the compiler every write may change a member, which it then reads again
  const ModuleTypeId* const types = step_.old.types + first_;
  const std::uint32_t* const siteModule = siteModule_.data();
  const std::uint32_t* const groupOf = groupOf_.data();
  std::uint32_t* const siteGroup = siteGroup_.data();
  std::uint32_t* const siteBlock = siteBlock_.data();
  std::uint32_t* const sorted = sorted_.data();
  const auto groupCount = static_cast<std::uint32_t>(plan_->groups().size());
  // two counts for each group, for even and odd sites: with one count every addition waits for the last addition
  std::uint32_t* const counts = groupCounts_.data();
  std::fill(groupCounts_.begin(), groupCounts_.end(), 0U);
  std::size_t siteCount = siteCount_;
  for (std::size_t site = 0; site < siteCount; ++site) {
    const std::uint32_t group = groupOf[types[siteModule[site]]];
    siteGroup[site] = group;
    ++counts[2 * group + (site & 1U)];
  }
  const std::uint32_t fixed = groupCount;
  const std::uint32_t general = groupCount + 1;
  if (counts[2 * general] + counts[2 * general + 1] > 0) {
    // the chunk ends at the first module for the general way
    const auto last = static_cast<std::size_t>(std::find(siteGroup, siteGroup + siteCount, general) - siteGroup);
    end_ = first_ + siteModule[last];
    endOffset_ = offset_ + siteOffset_[last];
    for (std::size_t site = last; site < siteCount; ++site) {
      --counts[2 * siteGroup[site] + (site & 1U)];
    }
    siteCount = last;
    siteCount_ = last;
  }
  std::fill_n(siteBlock, siteCount, 0U);
  if (counts[2 * fixed] + counts[2 * fixed + 1] > 0) {
    isResized_ = true;
    for (std::size_t site = 0; site < siteCount; ++site) {
      if (siteGroup[site] == fixed) {
        siteBlock[site] = plan_->indexOf(types[siteModule[site]]);
      }
    }
  }
  // counts become places
  std::uint32_t begin = 0;
  for (std::uint32_t group = 0; group < groupCount; ++group) {
    groupBegin_[group] = begin;
    for (std::uint32_t parity = 0; parity < 2; ++parity) {
      begin += std::exchange(counts[2 * group + parity], begin);
    }
  }
  groupBegin_[groupCount] = begin;
  counts[2 * fixed] = begin;
  counts[2 * fixed + 1] = begin;
  for (std::size_t site = 0; site < siteCount; ++site) {
    const std::uint32_t group = siteGroup[site];
    const std::size_t place = 2 * group + (site & 1U);
    sorted[counts[place]] = static_cast<std::uint32_t>(site);
    counts[place] += group != fixed ? 1 : 0;
  }
}

void BatchRewriter::chooseGroup(const BatchGroup& group, std::span<const std::uint32_t> sites) {
  lightSites_ += group.isLight ? sites.size() : 0;
  // the neighbours are the same for all rules
  if (group.looksLeft) {
    findLeft(sites);
  }
  if (group.looksRight) {
    findRight(sites);
  }
  if (!group.isWeighted) {
    chooseFirst(group, sites);
  } else if (group.hasThresholds) {
    chooseByThresholds(group, sites);
  } else {
    chooseByWeights(group, sites);
  }
}

void BatchRewriter::chooseFirst(const BatchGroup& group, std::span<const std::uint32_t> sites) {
  const std::uint32_t* const siteBlock = siteBlock_.data();
  std::uint32_t* const remaining = remaining_.data();
  for (std::uint32_t i = 0; i < group.ruleCount && !sites.empty(); ++i) {
    const BatchRule& rule = plan_->rules()[group.firstRule + i];
    std::size_t count = match(rule, static_cast<std::uint8_t>(1U << std::min(i, 7U)), sites);
    count = keepWhereTrue(rule, count);
    accept(rule, count);
    // the others try the next rule
    if (count > 0 && i + 1 < group.ruleCount) {
      std::size_t left = 0;
      for (const std::uint32_t site : sites) {
        remaining[left] = site;
        left += siteBlock[site] == 0 ? 1 : 0;
      }
      sites = {remaining, left};
    }
  }
}

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
      rows_.resize(std::max(rows_.size(), rowsUsed_ + sites.size() * (rule.production->leftContext.size() +
                                                                      rule.production->rightContext.size())));
      for (const std::uint32_t site : sites) {
        if ((siteBits_[site] & bit) != 0 && matchSearched(rule, site, lane)) {
          laneSite_[lane++] = site;
        }
      }
      break;
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

bool BatchRewriter::matchSearched(const BatchRule& rule, std::uint32_t site, std::size_t lane) {
  const language::Production& production = *rule.production;
  const std::uint64_t module = first_ + siteModule_[site];
  const std::uint64_t offset = offset_ + siteOffset_[site];
  // the modules of the predecessor behind the first
  const std::size_t length = production.predecessor.size();
  std::uint64_t behind = offset + program_->arity[step_.old.types[module]];
  if (length > 1) {
    if (step_.old.size - module < length) {
      return false;
    }
    for (std::size_t i = 1; i < length; ++i) {
      const ModuleTypeId type = step_.old.types[module + i];
      if (type != production.predecessor[i].type) {
        return false;
      }
      behind += program_->arity[type];
    }
    if (production.rightContext.empty() && production.leftContext.empty()) {
      return true;
    }
  }
  const std::size_t leftCount = production.leftContext.size();
  std::uint64_t* const row = rows_.data() + rowsUsed_;
  if ((!production.rightContext.empty() &&
       !derivation::findRight(*program_, *rules_, step_.old, production.rightContext, module + length, behind,
                              row + leftCount)) ||
      (leftCount > 0 &&
       !derivation::findLeft(*program_, *rules_, step_.old, production.leftContext, module, offset, row))) {
    return false;
  }
  laneLeft_[lane] = rowsUsed_;
  rowsUsed_ += leftCount + production.rightContext.size();
  return true;
}

void BatchRewriter::setLanes(const BatchRule& rule, std::size_t begin, std::size_t count) {
  const std::uint32_t* const site = laneSite_.data() + begin;
  const std::uint32_t* const siteOffset = siteOffset_.data();
  std::uint32_t* const own = own_.data();
  for (std::size_t i = 0; i < count; ++i) {
    own[i] = siteOffset[site[i]];
  }
  if (rule.drawsRandom) {
    for (std::size_t i = 0; i < count; ++i) {
      modules_[i] = first_ + siteModule_[site[i]];
    }
  }
  evaluator_.setLanes({count, rule.slots.data(), step_.old.parameters + offset_, step_.old.parameters, rows_.data(),
                       own_.data(), laneLeft_.data() + begin, laneRight_.data() + begin, modules_.data()});
}

std::size_t BatchRewriter::keepWhereTrue(const BatchRule& rule, std::size_t count) {
  if (!rule.condition && !rule.hasBefore) {
    return count;
  }
  constexpr std::size_t kStride = 2 * kChunkModules;
  std::uint32_t* const laneSite = laneSite_.data();
  std::uint64_t* const laneLeft = laneLeft_.data();
  std::uint64_t* const laneRight = laneRight_.data();
  double* const keptLocals = keptLocals_.data();
  const bool hasNeighbours = rule.context != BatchRule::Context::None;
  std::size_t kept = laneCount_;
  for (std::size_t begin = laneCount_; begin < laneCount_ + count; begin += ColumnEvaluator::kLanes) {
    const std::size_t size = std::min(ColumnEvaluator::kLanes, laneCount_ + count - begin);
    setLanes(rule, begin, size);
    if (rule.hasBefore) {
      evaluator_.run(rule.before);
      noteStores(rule, rule.before, begin, size, false);
    }
    const ColumnValue truth = rule.condition ? evaluator_.value(*rule.condition) : ColumnValue{nullptr, 1.0};
    const auto isTrue = [&truth](std::size_t i) {
      return (truth.values == nullptr ? truth.constant : truth.values[i]) != 0.0;
    };
    for (std::size_t k = 0; k < rule.kept.size(); ++k) {
      const double* const values = evaluator_.local(rule.kept[k]);
      double* const target = keptLocals + k * kStride;
      std::size_t next = kept;
      for (std::size_t i = 0; i < size; ++i) {
        target[next] = values[i];
        next += isTrue(i) ? 1 : 0;
      }
    }
    if (hasNeighbours) {
      for (std::size_t i = 0; i < size; ++i) {
        laneSite[kept] = laneSite[begin + i];
        laneLeft[kept] = laneLeft[begin + i];
        laneRight[kept] = laneRight[begin + i];
        kept += isTrue(i) ? 1 : 0;
      }
    } else {
      for (std::size_t i = 0; i < size; ++i) {
        laneSite[kept] = laneSite[begin + i];
        kept += isTrue(i) ? 1 : 0;
      }
    }
  }
  return kept - laneCount_;
}

void BatchRewriter::noteStores(const BatchRule& rule, const ColumnCode& code, std::size_t begin, std::size_t count,
                               bool isBehind) {
  const std::uint32_t* const site = laneSite_.data() + begin;
  for (const std::uint32_t local : code.stores) {
    const std::uint64_t* const isStored = evaluator_.storing(code, local);
    // the last module of the string
    std::size_t last = count;
    for (std::size_t i = 0; i < count; ++i) {
      if ((isStored == nullptr || isStored[i] != 0) && (last == count || site[i] > site[last])) {
        last = i;
      }
    }
    if (last < count) {
      stores_.note(rule.statics[local], 2 * (first_ + siteModule_[site[last]]) + (isBehind ? 1 : 0),
                   evaluator_.local(local)[last]);
    }
  }
}

void BatchRewriter::accept(const BatchRule& rule, std::size_t count) {
  if (count == 0) {
    return;
  }
  isChanged_ = true;
  isResized_ = isResized_ || plan_->blocks()[rule.block].isResizing;
  const std::uint32_t* const site = laneSite_.data() + laneCount_;
  std::uint32_t* const siteBlock = siteBlock_.data();
  const std::uint32_t block = rule.block;
  for (std::size_t i = 0; i < count; ++i) {
    siteBlock[site[i]] = block;
  }
  if (rule.needsLanes) {
    ruleLanes_.push_back({&rule, laneCount_, count});
    laneCount_ += count;
  }
}

void BatchRewriter::loadKept(const BatchRule& rule, std::size_t begin, std::size_t count) {
  for (std::size_t k = 0; k < rule.kept.size(); ++k) {
    std::copy_n(keptLocals_.data() + k * 2 * kChunkModules + begin, count, evaluator_.local(rule.kept[k]));
  }
}

void BatchRewriter::moveLane(const BatchRule& rule, std::size_t from, std::size_t to) {
  laneSite_[to] = laneSite_[from];
  laneLeft_[to] = laneLeft_[from];
  laneRight_[to] = laneRight_[from];
  for (std::size_t k = 0; k < rule.kept.size(); ++k) {
    keptLocals_[k * 2 * kChunkModules + to] = keptLocals_[k * 2 * kChunkModules + from];
  }
}

void BatchRewriter::dropOverlapped() {
  // from left to right: where a predecessor has begun, none begins before its end
  std::uint64_t next = 0;
  bool areDropped = false;
  for (std::size_t site = 0; site < siteCount_; ++site) {
    if (siteBlock_[site] == 0) {
      continue;
    }
    if (siteModule_[site] < next) {
      siteBlock_[site] = 0;
      areDropped = true;
      continue;
    }
    next = std::uint64_t{siteModule_[site]} + plan_->blocks()[siteBlock_[site]].readModules;
  }
  for (; end_ - first_ < next; ++end_) {
    endOffset_ += program_->arity[step_.old.types[end_]];
  }
  if (!areDropped) {
    return;
  }
  for (RuleLanes& lanes : ruleLanes_) {
    std::size_t kept = lanes.begin;
    for (std::size_t lane = lanes.begin; lane < lanes.begin + lanes.count; ++lane) {
      if (siteBlock_[laneSite_[lane]] == lanes.rule->block) {
        moveLane(*lanes.rule, lane, kept);
        ++kept;
      }
    }
    lanes.count = kept - lanes.begin;
  }
}

void BatchRewriter::place() {
  const BatchBlock* const blocks = plan_->blocks().data();
  const std::uint32_t* const siteModule = siteModule_.data();
  const std::uint32_t* const siteOffset = siteOffset_.data();
  const std::uint32_t* const siteBlock = siteBlock_.data();
  std::uint32_t* const madeModule = madeModule_.data();
  std::uint32_t* const madeOffset = madeOffset_.data();
  std::uint32_t* const resizing = resizing_.data();
  // growth may be negative: sums of unsigned numbers wrap around and come back
  std::uint32_t moduleGrowth = 0;
  std::uint32_t parameterGrowth = 0;
  std::size_t resizingCount = 0;
  for (std::size_t site = 0; site < siteCount_; ++site) {
    const BatchBlock& block = blocks[siteBlock[site]];
    madeModule[site] = siteModule[site] + moduleGrowth;
    madeOffset[site] = siteOffset[site] + parameterGrowth;
    moduleGrowth += static_cast<std::uint32_t>(block.moduleGrowth);
    parameterGrowth += static_cast<std::uint32_t>(block.parameterGrowth);
    resizing[resizingCount] = static_cast<std::uint32_t>(site);
    resizingCount += block.isResizing ? 1 : 0;
  }
  resizingCount_ = resizingCount;
  madeModules_ = static_cast<std::uint32_t>(end_ - first_) + moduleGrowth;
  madeParameters_ = static_cast<std::uint32_t>(endOffset_ - offset_) + parameterGrowth;
}

}  // namespace espalier::derivation

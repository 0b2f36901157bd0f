#include "engine/derivation/batch/batch_rewriter.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <utility>

#include "engine/core/check.h"
#include "engine/derivation/batch/unrolled.h"
#include "engine/derivation/matching/production_plan.h"
#include "engine/derivation/state/string_part.h"

namespace espalier::derivation {
namespace {

using core::ModuleTypeId;

// modules or parameters of a chunk and the part that is cut behind it: more do not fit into a BatchBlock
constexpr std::uint64_t kMostCutModules = 1U << 30U;

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
      blocks_(plan.blocks()),
      siteModule_(kChunkModules + ModuleFinder::kSlack),
      siteOffset_(kChunkModules + ModuleFinder::kSlack),
      siteBits_(kChunkModules + ModuleFinder::kSlack),
      siteBlock_(kChunkModules),
      siteDraws_(plan.drawsRandom() ? kChunkModules : 0),
      madeModule_(kChunkModules),
      madeOffset_(kChunkModules),
      resizing_(kChunkModules + 1),
      allSites_(kChunkModules),
      sorted_((plan.groups().size() + 2) * kChunkModules),
      groupOf_(program.moduleTypeCount(), 0),
      groupEnds_(plan.groups().size() + 2),
      remaining_(kChunkModules),
      laneSite_(2 * kChunkModules),
      laneLeft_(2 * kChunkModules),
      laneRight_(2 * kChunkModules),
      leftType_(kChunkModules),
      rightType_(kChunkModules),
      leftOffset_(kChunkModules),
      rightOffset_(kChunkModules),
      leftModule_(kChunkModules),
      rightModule_(kChunkModules),
      contexts_(program, rules, kChunkModules),
      siteRow_(kChunkModules),
      keptColumns_(2 * kChunkModules * plan.largestKeptCount()),
      true_(ColumnEvaluator::kLanes),
      modules_(ColumnEvaluator::kLanes),
      words_(kChunkModules + 8),
      positions_(kChunkModules),
      isCovered_(kChunkModules) {
  std::iota(allSites_.begin(), allSites_.end(), 0U);
  for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
    const auto type = static_cast<ModuleTypeId>(i);
    switch (plan.classOf(type)) {
      case BatchPlan::Class::Group:
        groupOf_[type] = plan.indexOf(type);
        break;
      case BatchPlan::Class::Fixed:
      case BatchPlan::Class::Cut:
        groupOf_[type] = static_cast<std::uint32_t>(plan.groups().size());
        break;
      case BatchPlan::Class::General:
        groupOf_[type] = static_cast<std::uint32_t>(plan.groups().size() + 1);
        break;
      case BatchPlan::Class::Kept:
        break;
    }
  }
}

void BatchRewriter::begin(const Step& step) {
  step_ = step;
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
  possibleStores_.clear();
  evaluator_.clearUnusual();
  if (plan_->isFixedOnly()) {
    return countFixed();
  }

  collectSites();
  if (plan_->drawsRandom()) {
    std::fill_n(siteDraws_.begin(), siteCount_, ModuleDraws{});
  }
  if (plan_->hasOneKindOnly()) {
    std::fill_n(siteBlock_.begin(), siteCount_, 0U);
    if (siteCount_ > 0) {
      chooseGroup(plan_->groups().front(), {allSites_.data(), siteCount_});
    }
  } else {
    sortSites();
    // fixed blocks follow the groups
    lightSites_ = sitesOf(plan_->groups().size()).size();
    for (std::size_t i = 0; i < plan_->groups().size(); ++i) {
      if (!sitesOf(i).empty()) {
        chooseGroup(plan_->groups()[i], sitesOf(i));
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
  if (plan_->hasCuts()) {
    dropCutParts();
  }
}

void BatchRewriter::dropPairs() {
  // local pointers: the compiler would read members again after each write of a byte, which may have changed them
  const ModuleTypeId* const types = step_.old.types + first_;
  const std::uint8_t* const leftBits = plan_->leftBits();
  const std::uint8_t* const rightBits = plan_->rightBits();
  const std::size_t stride = plan_->pairStride();
  std::uint32_t* const siteModule = siteModule_.data();
  std::uint32_t* const siteOffset = siteOffset_.data();
  std::uint8_t* const siteBits = siteBits_.data();
  const std::size_t siteCount = siteCount_;
  const bool isAtBegin = first_ == 0;
  const std::uint64_t last = step_.old.size - first_ - 1;
  // beyond the ends of the string every type is possible
  const auto unknown = static_cast<std::size_t>(program_->moduleTypeCount());
  std::size_t kept = 0;
  for (std::size_t site = 0; site < siteCount; ++site) {
    const std::uint32_t module = siteModule[site];
    const std::size_t type = types[module];
    const std::size_t before = isAtBegin && module == 0 ? unknown : *(types + module - 1);
    const std::size_t behind = module == last ? unknown : types[module + 1];
    const auto bits = static_cast<std::uint8_t>(leftBits[before * stride + type] & rightBits[type * stride + behind]);
    siteModule[kept] = module;
    siteOffset[kept] = siteOffset[site];
    siteBits[kept] = bits;
    kept += bits != 0 ? 1 : 0;
  }
  siteCount_ = kept;
}

void BatchRewriter::dropCutParts() {
  blocks_.resize(plan_->blocks().size());
  std::uint64_t next = 0;  // behind the last part
  std::size_t kept = 0;
  for (std::size_t site = 0; site < siteCount_; ++site) {
    const std::uint64_t module = siteModule_[site];
    if (module < next) {
      continue;
    }
    siteModule_[kept] = siteModule_[site];
    siteOffset_[kept] = siteOffset_[site];
    siteBits_[kept] = siteBits_[site];
    ++kept;
    if (plan_->classOf(step_.old.types[first_ + module]) != BatchPlan::Class::Cut) {
      continue;
    }
    const std::uint64_t offset = offset_ + siteOffset_[site];
    const StringPart part = findCutPart(*program_, {step_.old.types, step_.old.size}, first_ + module, offset);
    next = part.endModule - first_;
    isUnusual_ = isUnusual_ || next > kMostCutModules || part.endParameter - offset_ > kMostCutModules;
    if (part.endModule > end_) {
      end_ = part.endModule;
      endOffset_ = part.endParameter;
    }
    // nothing takes the place of the symbol and the part
    BatchBlock& block = blocks_.emplace_back();
    block.readModules = static_cast<std::uint32_t>(next - module);
    block.readParameters = static_cast<std::uint32_t>(part.endParameter - offset);
    block.moduleGrowth = -static_cast<std::int32_t>(block.readModules);
    block.parameterGrowth = -static_cast<std::int32_t>(block.readParameters);
    block.isResizing = true;
  }
  siteCount_ = kept;
}

void BatchRewriter::sortSites() {
  // local pointers: the compiler would read members again after each write, which may have changed them
  const ModuleTypeId* const types = step_.old.types + first_;
  const std::uint32_t* const siteModule = siteModule_.data();
  const std::uint32_t* const groupOf = groupOf_.data();
  std::uint32_t* const sorted = sorted_.data();
  std::uint32_t* const ends = groupEnds_.data();
  const std::size_t siteCount = siteCount_;
  for (std::size_t group = 0; group < groupEnds_.size(); ++group) {
    ends[group] = static_cast<std::uint32_t>(group * kChunkModules);
  }
  for (std::size_t site = 0; site < siteCount; ++site) {
    sorted[ends[groupOf[types[siteModule[site]]]]++] = static_cast<std::uint32_t>(site);
  }
  const std::size_t fixed = plan_->groups().size();
  const std::size_t general = fixed + 1;
  if (!sitesOf(general).empty()) {
    // the chunk ends at the first module for the general way
    const std::uint32_t last = sitesOf(general).front();
    end_ = first_ + siteModule[last];
    endOffset_ = offset_ + siteOffset_[last];
    siteCount_ = last;
    for (std::size_t group = 0; group < general; ++group) {
      while (!sitesOf(group).empty() && sitesOf(group).back() > last) {
        --ends[group];
      }
    }
  }
  std::fill_n(siteBlock_.begin(), siteCount_, 0U);
  auto nextCut = static_cast<std::uint32_t>(plan_->blocks().size());
  for (const std::uint32_t site : sitesOf(fixed)) {
    isResized_ = true;
    const ModuleTypeId type = types[siteModule[site]];
    siteBlock_[site] = plan_->classOf(type) == BatchPlan::Class::Cut ? nextCut++ : plan_->indexOf(type);
  }
}

void BatchRewriter::chooseGroup(const BatchGroup& group, std::span<const std::uint32_t> sites) {
  lightSites_ += group.isLight ? sites.size() : 0;
  findNeighbours(group, sites);
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
    std::size_t count = match(rule, sites);
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

void BatchRewriter::setLanes(const BatchRule& rule, std::size_t begin, std::size_t count) {
  const std::uint32_t* const site = laneSite_.data() + begin;
  if (rule.drawsRandom) {
    for (std::size_t i = 0; i < count; ++i) {
      modules_[i] = first_ + siteModule_[site[i]];
    }
  }
  evaluator_.setLanes({count, rule.slots.data(), step_.old.parameters + offset_, step_.old.parameters, rows_.data(),
                       site, siteOffset_.data(), laneLeft_.data() + begin, laneRight_.data() + begin,
                       rule.drawsRandom ? modules_.data() : nullptr, siteDraws_.data()});
}

std::size_t BatchRewriter::findTrue(const ColumnValue& truth, std::size_t count) {
  const double* const values = truth.values;
  std::uint32_t* const lanes = true_.data();
  // often all are true
  if (std::find(values, values + count, 0.0) == values + count) {
    return count;
  }
  std::size_t found = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    lanes[found] = i;
    found += values[i] != 0.0 ? 1 : 0;
  }
  return found;
}

std::size_t BatchRewriter::keepWhereTrue(const BatchRule& rule, std::size_t count) {
  if (!rule.condition && !rule.hasBefore) {
    return count;
  }
  constexpr std::size_t kStride = 2 * kChunkModules;
  std::uint32_t* const laneSite = laneSite_.data();
  std::uint64_t* const laneLeft = laneLeft_.data();
  std::uint64_t* const laneRight = laneRight_.data();
  double* const keptColumns = keptColumns_.data();
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
    const std::size_t trueCount = truth.values == nullptr ? (truth.constant != 0.0 ? size : 0) : findTrue(truth, size);
    // the kept columns, sites and neighbours of the lanes that stay move to the front
    const auto keep = [size, trueCount, lanes = true_.data()](auto* target, const auto* source) {
      if (trueCount == size) {
        if (target != source) {
          std::copy(source, source + size, target);
        }
        return;
      }
      unrolled(trueCount, [=](std::size_t i) { target[i] = source[lanes[i]]; });
    };
    for (std::size_t k = 0; k < rule.kept.size(); ++k) {
      keep(keptColumns + k * kStride + kept, evaluator_.column(rule.kept[k]));
    }
    if (hasNeighbours) {
      keep(laneLeft + kept, laneLeft + begin);
      keep(laneRight + kept, laneRight + begin);
    }
    keep(laneSite + kept, laneSite + begin);
    kept += trueCount;
  }
  return kept - laneCount_;
}

void BatchRewriter::noteStores(const BatchRule& rule, const ColumnCode& code, std::size_t begin, std::size_t count,
                               bool isBehind) {
  const std::uint32_t* const site = laneSite_.data() + begin;
  for (const std::uint32_t local : code.stores) {
    const std::uint64_t* const isStored = evaluator_.storing(code, local);
    // the last module of the string that has stored: lanes are in its order
    std::size_t last = count;
    while (isStored != nullptr && last > 0 && isStored[last - 1] == 0) {
      --last;
    }
    if (!isBehind && plan_->hasLongPredecessors()) {
      // dropOverlapped() knows where an earlier predecessor wins: there the block has not run
      for (std::size_t i = 0; i < last; ++i) {
        if (isStored == nullptr || isStored[i] != 0) {
          possibleStores_.push_back({site[i], rule.statics[local], evaluator_.column(local)[i]});
        }
      }
      continue;
    }
    if (last > 0) {
      stores_.note(rule.statics[local], 2 * (first_ + siteModule_[site[last - 1]]) + (isBehind ? 1 : 0),
                   evaluator_.column(local)[last - 1]);
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
  unrolled(count, [=](std::size_t i) { siteBlock[site[i]] = block; });
  if (rule.needsLanes) {
    ruleLanes_.push_back({&rule, laneCount_, count});
    laneCount_ += count;
  }
}

void BatchRewriter::loadKept(const BatchRule& rule, std::size_t begin, std::size_t count) {
  for (std::size_t k = 0; k < rule.kept.size(); ++k) {
    std::copy_n(keptColumns_.data() + k * 2 * kChunkModules + begin, count, evaluator_.column(rule.kept[k]));
  }
}

void BatchRewriter::moveLane(const BatchRule& rule, std::size_t from, std::size_t to) {
  laneSite_[to] = laneSite_[from];
  laneLeft_[to] = laneLeft_[from];
  laneRight_[to] = laneRight_[from];
  for (std::size_t k = 0; k < rule.kept.size(); ++k) {
    keptColumns_[k * 2 * kChunkModules + to] = keptColumns_[k * 2 * kChunkModules + from];
  }
}

void BatchRewriter::dropOverlapped() {
  // from left to right: where a predecessor has begun, none begins before its end
  std::uint64_t next = 0;
  bool areDropped = false;
  for (std::size_t site = 0; site < siteCount_; ++site) {
    isCovered_[site] = siteModule_[site] < next ? 1 : 0;
    if (siteBlock_[site] == 0) {
      continue;
    }
    if (isCovered_[site] != 0) {
      siteBlock_[site] = 0;
      areDropped = true;
      continue;
    }
    next = std::uint64_t{siteModule_[site]} + blocks_[siteBlock_[site]].readModules;
  }
  for (; end_ - first_ < next; ++end_) {
    endOffset_ += program_->arity[step_.old.types[end_]];
  }
  for (const PossibleStore& store : possibleStores_) {
    if (isCovered_[store.site] == 0) {
      stores_.note(store.variable, 2 * (first_ + siteModule_[store.site]), store.value);
    }
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

std::uint64_t BatchRewriter::placeOfResult(std::uint64_t module) const {
  const auto place = static_cast<std::uint32_t>(module - first_);
  const std::uint32_t* const begin = siteModule_.data();
  // the last site at or before the module; behind it the modules have moved as far as its block has grown
  const auto before = static_cast<std::size_t>(std::upper_bound(begin, begin + siteCount_, place) - begin);
  if (!isResized_ || before == 0) {
    return place;
  }
  const std::size_t site = before - 1;
  const std::uint32_t behind = place - siteModule_[site];
  const auto growth = static_cast<std::uint32_t>(blocks_[siteBlock_[site]].moduleGrowth);
  return madeModule_[site] + (behind == 0 ? 0 : behind + growth);
}

void BatchRewriter::place() {
  const BatchBlock* const blocks = blocks_.data();
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

#include "engine/derivation/batch/batch_plan.h"

#include <algorithm>
#include <cmath>

namespace espalier::derivation {
namespace {

using language::ContextElement;
using language::Production;

// for more weights than this a table of thresholds does not pay
constexpr std::size_t kMaximumThresholds = 32;
constexpr std::uint8_t kAllBits = 0xFF;
// marks of sites: one for modules that may change beside any neighbours, the others for rules
constexpr std::uint8_t kAnywhere = 0x80;
constexpr std::size_t kRuleMarks = 7;

std::uint8_t bitOf(std::size_t candidate) {
  return static_cast<std::uint8_t>(1U << std::min<std::size_t>(candidate, 7));
}

/// Whether the neighbour that a search meets first may match the context. `isBracket`: a bracket that this kind of
/// search passes or enters.
bool canBeNext(const std::vector<ContextElement>& context, core::ModuleTypeId neighbour, bool isBracket) {
  return context.empty() || isBracket || context[0].kind == ContextElement::Kind::SkipToBranchEnd ||
         context[0].module.type == neighbour;
}

bool isBatchProduction(const language::Program& program, const language::LSystem& system,
                       const Production& production) {
  if (production.predecessor.size() != 1 || !production.newLeftContext.empty() || !production.newRightContext.empty() ||
      !production.preBlock.empty() || !production.postBlock.empty()) {
    return false;
  }
  const auto isColumn = [&](const language::Expression& expression) { return isColumnExpression(program, expression); };
  const auto isValue = [&](const language::Expression& expression) {
    return isDrawingColumnExpression(program, expression);
  };
  if ((production.condition && !isColumn(*production.condition)) ||
      (system.isStochastic && production.probability && !isColumn(*production.probability)) ||
      !std::all_of(production.expressions.begin(), production.expressions.end(), isValue)) {
    return false;
  }
  return std::none_of(
      production.successor.begin(), production.successor.end(),
      [&](const language::SuccessorModule& module) { return system.decomposition.mayApplyTo(module.type); });
}

bool hasContexts(const Production& production) {
  return !production.leftContext.empty() || !production.rightContext.empty();
}

/// Whether a context is one module, for which the search passes branches.
bool isNear(const std::vector<ContextElement>& context) {
  return context.empty() || (context.size() == 1 && (context[0].kind == ContextElement::Kind::Module ||
                                                     context[0].kind == ContextElement::Kind::CloseBranch));
}

}  // namespace

BatchPlan::BatchPlan(const language::Program& program, const language::LSystem& system, const ContextRules& rules,
                     const ProductionPlan& plan)
    : classes_(program.moduleTypeCount(), Class::Kept),
      indices_(program.moduleTypeCount(), 0),
      candidateBits_(program.moduleTypeCount() + 1, 0) {
  // block 0, of modules that stay: nothing moves
  blocks_.emplace_back();
  blockTypes_.emplace_back();
  bool hasFixed = false;
  for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
    const auto type = static_cast<core::ModuleTypeId>(i);
    planType(program, system, rules, plan, type);
    isComplete_ = isComplete_ && classes_[type] != Class::General;
    isQuick_ = isQuick_ && (classes_[type] != Class::Group || plan[type].kind != TypePlan::Kind::General);
    hasFixed = hasFixed || classes_[type] == Class::Fixed;
  }
  hasOneKindOnly_ = isComplete_ && !hasFixed && groups_.size() == 1;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    blocks_[i].allTypes = blockTypes_[i].data();
  }
  if (isFixedOnly()) {
    fixedBlocks_ = FixedBlocks(program, plan);
  }
  makePairs(program, rules);
  makeSiteMarks(program, rules);
}

void BatchPlan::planType(const language::Program& program, const language::LSystem& system, const ContextRules& rules,
                         const ProductionPlan& plan, core::ModuleTypeId type) {
  const TypePlan& typePlan = plan[type];
  const std::uint16_t arity = program.arity[type];
  if (typePlan.kind == TypePlan::Kind::Fixed) {
    // the module itself, or a block without parameters
    const core::ModuleTypeId* types = plan.types() + typePlan.firstType;
    if (typePlan.length == 1 && types[0] == type && typePlan.copied == arity) {
      return;
    }
    classes_[type] = Class::Fixed;
    indices_[type] = static_cast<std::uint32_t>(blocks_.size());
    candidateBits_[type] = kAllBits;
    addBlock({types, types + typePlan.length}, typePlan.copied, arity);
    // a fixed block is always written, even when it has the size of the old module
    blocks_.back().isResizing = true;
    return;
  }
  classes_[type] = Class::General;
  candidateBits_[type] = kAllBits;
  if (system.productions.index.empty()) {
    return;
  }
  const auto candidates = system.productions.index.candidates(type);
  if (candidates.empty()) {
    return;
  }
  BatchGroup group;
  group.isWeighted = system.isStochastic;
  group.firstRule = static_cast<std::uint32_t>(rules_.size());
  bool isUnmatchedPossible = true;
  std::size_t used = 0;
  for (const std::uint32_t index : candidates) {
    const Production& production = system.productions.productions[index];
    if (!isBatchProduction(program, system, production)) {
      return;
    }
    ++used;
    const bool isAlways = !production.condition && !hasContexts(production);
    isUnmatchedPossible = isUnmatchedPossible && !isAlways;
    // a production without a condition always matches: later productions have no effect
    if (isAlways && !system.isStochastic) {
      break;
    }
  }
  // the general way decides about an unmatched module
  if (isUnmatchedPossible && (system.decomposition.mayApplyTo(type) || program.nameOf(type) == "%")) {
    return;
  }
  for (std::size_t i = 0; i < used; ++i) {
    addRule(program, system.productions.productions[candidates[i]], rules, system.isStochastic);
    group.looksLeft = group.looksLeft || rules_.back().left != core::kNoModuleType;
    group.looksRight = group.looksRight || rules_.back().right != core::kNoModuleType;
    candidateBits_[type] = static_cast<std::uint8_t>(i == 0 ? bitOf(i) : candidateBits_[type] | bitOf(i));
  }
  group.ruleCount = static_cast<std::uint32_t>(used);
  group.isLight = isLight(plan, typePlan);
  findThresholds(group);
  largestRuleCount_ = std::max<std::size_t>(largestRuleCount_, used);
  classes_[type] = Class::Group;
  indices_[type] = static_cast<std::uint32_t>(groups_.size());
  groups_.push_back(std::move(group));
}

bool BatchPlan::isLight(const ProductionPlan& plan, const TypePlan& typePlan) const {
  if (typePlan.kind != TypePlan::Kind::Rules || typePlan.usesCode || typePlan.ruleCount != 1 ||
      !blocks_[rules_.back().block].isResizing) {
    return false;
  }
  const QuickRule& rule = plan.rules()[typePlan.firstRule];
  const QuickValue* const values = plan.values() + rule.firstValue;
  return std::all_of(values, values + rule.valueCount,
                     [](const QuickValue& value) { return value.form == QuickValue::Form::Constant; });
}

void BatchPlan::addBlock(const std::vector<core::ModuleTypeId>& types, std::uint32_t valueCount, std::uint16_t arity) {
  BatchBlock block;
  block.length = static_cast<std::uint32_t>(types.size());
  block.valueCount = valueCount;
  block.moduleGrowth = static_cast<std::int32_t>(types.size()) - 1;
  block.parameterGrowth = static_cast<std::int32_t>(valueCount) - arity;
  block.isResizing = block.moduleGrowth != 0 || block.parameterGrowth != 0;
  std::copy_n(types.begin(), std::min(types.size(), block.types.size()), block.types.begin());
  blocks_.push_back(block);
  blockTypes_.push_back(types);
}

void BatchPlan::addRule(const language::Program& program, const Production& production, const ContextRules& rules,
                        bool usesWeights) {
  BatchRule rule;
  rule.production = &production;
  const core::ModuleTypeId type = production.predecessor[0].type;
  const std::uint16_t arity = program.arity[type];
  if (hasContexts(production)) {
    rule.context = !rules.isRing() && isNear(production.leftContext) && isNear(production.rightContext)
                       ? BatchRule::Context::Near
                       : BatchRule::Context::Searched;
  }

  // the sources of the formal parameters
  for (std::uint32_t i = 0; i < production.slotCount; ++i) {
    rule.slots.push_back({SlotSource::Kind::Searched, i});
  }
  const auto bind = [&](const language::FormalModule& module, SlotSource::Kind kind) {
    for (std::uint32_t i = 0; i < program.arity[module.type]; ++i) {
      rule.slots[module.firstSlot + i] = {kind, i};
    }
  };
  bind(production.predecessor[0], SlotSource::Kind::Own);
  if (rule.context == BatchRule::Context::Near) {
    if (!production.leftContext.empty()) {
      rule.left = production.leftContext[0].module.type;
      bind(production.leftContext[0].module, SlotSource::Kind::Left);
    }
    if (!production.rightContext.empty()) {
      rule.right = production.rightContext[0].module.type;
      bind(production.rightContext[0].module, SlotSource::Kind::Right);
    }
  }
  largestSlotCount_ = std::max<std::size_t>(largestSlotCount_, production.slotCount);

  if (production.condition) {
    rule.condition = makeColumnExpression(program, *production.condition);
    addColumns(*rule.condition);
  }
  rule.weight.result.constant = 1.0;
  if (usesWeights && production.probability) {
    rule.weight = makeColumnExpression(program, *production.probability);
    addColumns(rule.weight);
  }
  std::vector<core::ModuleTypeId> types;
  std::uint32_t drawCount = 0;
  for (const language::SuccessorModule& module : production.successor) {
    types.push_back(module.type);
    for (std::uint32_t i = 0; i < program.arity[module.type]; ++i) {
      rule.values.push_back(
          makeColumnExpression(program, production.expressions[module.firstExpression + i], drawCount));
      drawCount += rule.values.back().drawCount;
      addColumns(rule.values.back());
    }
  }
  rule.block = static_cast<std::uint32_t>(blocks_.size());
  addBlock(types, static_cast<std::uint32_t>(rule.values.size()), arity);
  rule.changesParts = !blocks_.back().isResizing && types[0] != type;
  rule.drawsRandom = drawCount > 0;
  rule.needsLanes = !rule.values.empty() || rule.changesParts;
  rules_.push_back(std::move(rule));
}

void BatchPlan::addColumns(const ColumnExpression& expression) {
  for (const ColumnInstruction& instruction : expression.instructions) {
    largestColumnCount_ = std::max<std::size_t>(largestColumnCount_, instruction.target + std::size_t{1});
  }
}

void BatchPlan::findThresholds(BatchGroup& group) const {
  if (!group.isWeighted || group.ruleCount > kMaximumThresholds) {
    return;
  }
  std::vector<double> weights;
  double sum = 0.0;
  for (std::uint32_t i = 0; i < group.ruleCount; ++i) {
    const BatchRule& rule = rules_[group.firstRule + i];
    const ColumnOperand& weight = rule.weight.result;
    if (rule.context != BatchRule::Context::None || rule.condition || rule.weight.isPerLane ||
        weight.kind != ColumnOperand::Kind::Constant || !(weight.constant >= 0.0)) {
      return;
    }
    weights.push_back(weight.constant);
    sum += weight.constant;
  }
  if (!std::isfinite(sum)) {
    return;
  }
  // weights and roundings are monotone in the draw, so the words that choose a later rule than k are those below a
  // bound
  for (std::size_t k = 0; k + 1 < weights.size(); ++k) {
    std::uint64_t low = 0;
    std::uint64_t high = std::uint64_t{1} << 32U;
    while (low < high) {
      const std::uint64_t middle = (low + high) / 2;
      const double draw = 1.0 - static_cast<double>(middle) * 0x1.0p-32;
      if (chooseByWeight(weights, draw, false) > k) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    group.thresholds.push_back(low);
  }
  group.hasThresholds = true;
}

void BatchPlan::makePairs(const language::Program& program, const ContextRules& rules) {
  const std::size_t typeCount = program.moduleTypeCount();
  const bool hasNeighbours = std::any_of(
      rules_.begin(), rules_.end(), [](const BatchRule& rule) { return rule.context != BatchRule::Context::None; });
  if (!hasNeighbours || typeCount >= kMaximumPairTypes) {
    return;
  }
  hasPairs_ = true;
  pairStride_ = typeCount + 1;
  leftBits_.assign(pairStride_ * pairStride_, kAllBits);
  rightBits_.assign(pairStride_ * pairStride_, kAllBits);
  for (std::size_t i = 0; i < typeCount; ++i) {
    const auto type = static_cast<core::ModuleTypeId>(i);
    for (std::size_t j = 0; j <= typeCount; ++j) {
      const auto other = static_cast<core::ModuleTypeId>(j);
      std::uint8_t left = candidateBits_[type];
      std::uint8_t right = candidateBits_[type];
      if (classes_[type] == Class::Group && j < typeCount && !rules.isIgnored(other)) {
        left = 0;
        right = 0;
        const BatchGroup& group = groups_[indices_[type]];
        for (std::uint32_t k = 0; k < group.ruleCount; ++k) {
          const Production& production = *rules_[group.firstRule + k].production;
          // a search does not end at a bracket, except at `]` on the right, and at `[` when the context has it
          const bool isOpen = other == program.openBranch;
          if (canBeNext(production.leftContext, other, isOpen || other == program.closeBranch)) {
            left |= bitOf(k);
          }
          if (canBeNext(production.rightContext, other, isOpen)) {
            right |= bitOf(k);
          }
        }
      }
      leftBits_[j * pairStride_ + i] = left;
      rightBits_[i * pairStride_ + j] = right;
    }
  }
}

void BatchPlan::makeSiteMarks(const language::Program& program, const ContextRules& rules) {
  const std::size_t typeCount = program.moduleTypeCount();
  siteMarks_.own.assign(candidateBits_.begin(), candidateBits_.begin() + static_cast<std::ptrdiff_t>(typeCount));
  if (!hasPairs_) {
    return;
  }
  // one table for each side instead of pairs: rules have marks of their own as far as there are marks
  const auto markOf = [](std::size_t rule) { return static_cast<std::uint8_t>(1U << (rule % kRuleMarks)); };
  needsPairBits_ = rules_.size() > kRuleMarks;
  siteMarks_.before.assign(typeCount, kAnywhere);
  siteMarks_.behind.assign(typeCount, kAnywhere);
  for (std::size_t i = 0; i < typeCount; ++i) {
    const auto type = static_cast<core::ModuleTypeId>(i);
    if (classes_[i] == Class::Group) {
      siteMarks_.own[i] = 0;
      const BatchGroup& group = groups_[indices_[i]];
      for (std::uint32_t k = 0; k < group.ruleCount; ++k) {
        siteMarks_.own[i] |= markOf(group.firstRule + k);
      }
    } else if (classes_[i] != Class::Kept) {
      siteMarks_.own[i] = kAnywhere;
    }
    const bool isOpen = type == program.openBranch;
    for (std::size_t rule = 0; rule < rules_.size(); ++rule) {
      const Production& production = *rules_[rule].production;
      needsPairBits_ = needsPairBits_ || rules_[rule].context == BatchRule::Context::Searched;
      if (rules.isIgnored(type) || canBeNext(production.leftContext, type, isOpen || type == program.closeBranch)) {
        siteMarks_.before[i] |= markOf(rule);
      }
      if (rules.isIgnored(type) || canBeNext(production.rightContext, type, isOpen)) {
        siteMarks_.behind[i] |= markOf(rule);
      }
    }
  }
}

}  // namespace espalier::derivation

#include "engine/derivation/batch/batch_plan.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

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

/// Whether the production may apply before the neighbour. A predecessor of several modules has its second there.
bool canStandBefore(const Production& production, core::ModuleTypeId neighbour, bool isPassed) {
  return production.predecessor.size() > 1 ? production.predecessor[1].type == neighbour
                                           : canBeNext(production.rightContext, neighbour, isPassed);
}

/// The columns below `count` that the code reads.
void addReads(const ColumnCode& code, std::size_t count, std::vector<bool>& isRead) {
  const auto add = [&](const ColumnOperand& operand) {
    if (operand.kind == ColumnOperand::Kind::Column && operand.index < count) {
      isRead[operand.index] = true;
    }
  };
  for (const ColumnInstruction& instruction : code.instructions) {
    std::for_each_n(instruction.operands.begin(), instruction.count, add);
  }
  for (const ColumnStretch& stretch : code.stretches) {
    add(stretch.test);
  }
  add(code.result);
}

/// Whether two contexts seek the same modules.
bool seekSame(const std::vector<ContextElement>& a, const std::vector<ContextElement>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const ContextElement& x, const ContextElement& y) {
    return x.kind == y.kind && (x.kind == ContextElement::Kind::SkipToBranchEnd || x.module.type == y.module.type);
  });
}

/// Whether searches for the predecessors and contexts of two productions find the same modules.
bool findSamePlaces(const Production& a, const Production& b) {
  return seekSame(a.leftContext, b.leftContext) && seekSame(a.rightContext, b.rightContext) &&
         std::equal(a.predecessor.begin(), a.predecessor.end(), b.predecessor.begin(), b.predecessor.end(),
                    [](const language::FormalModule& x, const language::FormalModule& y) { return x.type == y.type; });
}

/// Whether a context is one module, for which the search passes branches.
bool isNear(const std::vector<ContextElement>& context) {
  return context.empty() || (context.size() == 1 && (context[0].kind == ContextElement::Kind::Module ||
                                                     context[0].kind == ContextElement::Kind::CloseBranch));
}

}  // namespace

BatchPlan::BatchPlan(const language::Program& program, const language::LSystem& system, const ContextRules& rules,
                     const ProductionPlan& plan, const BatchPlan* decomposition)
    : BatchPlan(program, system, rules, plan, system.productions, false, decomposition != nullptr) {}

std::optional<BatchPlan> BatchPlan::ofDecomposition(const language::Program& program, const language::LSystem& system,
                                                    const ContextRules& rules, const ProductionPlan& plan) {
  const language::ProductionList& list = system.decomposition;
  if (list.productions.empty() || list.maximumDepth == 0) {
    return std::nullopt;
  }
  BatchPlan made(program, system, rules, plan, list, true, false);
  return made.isComplete_ ? std::optional(std::move(made)) : std::nullopt;
}

BatchPlan::BatchPlan(const language::Program& program, const language::LSystem& system, const ContextRules& rules,
                     const ProductionPlan& plan, const language::ProductionList& list, bool isDecomposition,
                     bool decomposes)
    : classes_(program.moduleTypeCount(), Class::Kept),
      indices_(program.moduleTypeCount(), 0),
      candidateBits_(program.moduleTypeCount() + 1, 0),
      list_(&list),
      isDecomposition_(isDecomposition),
      isWeighted_(!isDecomposition && system.isStochastic),
      decomposes_(decomposes),
      problems_(program.moduleTypeCount(), "") {
  // block 0, of modules that stay: nothing moves
  blocks_.emplace_back();
  blockTypes_.emplace_back();
  for (const Production& production : list.productions) {
    hasLongPredecessors_ = hasLongPredecessors_ || production.predecessor.size() > 1;
  }
  bool hasFixed = false;  // or a Cut
  for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
    const auto type = static_cast<core::ModuleTypeId>(i);
    planType(program, system, rules, plan, type);
    isComplete_ = isComplete_ && classes_[type] != Class::General;
    // one at a time, a choice by weight draws alone
    isCheap_ = isCheap_ &&
               (classes_[type] != Class::Group || (plan[type].kind != TypePlan::Kind::General && !plan[type].usesCode &&
                                                   !(isWeighted_ && groups_.back().ruleCount > 1)));
    isQuick_ = isQuick_ && (classes_[type] != Class::Group || (plan[type].kind != TypePlan::Kind::General &&
                                                               plan[type].kind != TypePlan::Kind::BlocksOrContexts));
    hasCuts_ = hasCuts_ || classes_[type] == Class::Cut;
    hasFixed = hasFixed || classes_[type] == Class::Fixed || hasCuts_;
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
  const bool hasCandidates = !list_->index.empty() && !list_->index.candidates(type).empty();
  if (!hasCandidates && (isDecomposition_ || (decomposes_ && program.nameOf(type) != "%"))) {
    return;
  }
  // a predecessor of several modules may take the `%` with it
  if (type == program.cut && !hasCandidates && !system.decomposition.mayApplyTo(type) && !hasLongPredecessors_) {
    classes_[type] = Class::Cut;
    candidateBits_[type] = kAllBits;
    return;
  }
  if (!isDecomposition_ && typePlan.kind == TypePlan::Kind::Fixed) {
    // the module itself, or a block without parameters
    const core::ModuleTypeId* types = plan.types() + typePlan.firstType;
    if (typePlan.length == 1 && types[0] == type && typePlan.copied == arity) {
      return;
    }
    classes_[type] = Class::Fixed;
    indices_[type] = static_cast<std::uint32_t>(blocks_.size());
    candidateBits_[type] = kAllBits;
    addBlock({types, types + typePlan.length}, typePlan.copied, 1, arity);
    // a fixed block is always written, even when it has the size of the old module
    blocks_.back().isResizing = true;
    return;
  }
  if (!planGroup(program, system, rules, plan, type)) {
    classes_[type] = Class::General;
    candidateBits_[type] = kAllBits;
    problems_[type] = problem_;
  }
}

bool BatchPlan::planGroup(const language::Program& program, const language::LSystem& system, const ContextRules& rules,
                          const ProductionPlan& plan, core::ModuleTypeId type) {
  problem_ = "decomposition or the cut symbol decides about the module";
  if (list_->index.empty() || list_->index.candidates(type).empty()) {
    return false;
  }
  std::vector<BatchRule> made;
  bool isUnmatchedPossible = true;
  for (const std::uint32_t index : list_->index.candidates(type)) {
    const Production& production = list_->productions[index];
    if (!compile(program, system, production, made.emplace_back())) {
      return false;
    }
    bindSlots(program, rules, made.back());
    const bool isAlways = !production.condition && !hasContexts(production) && production.predecessor.size() == 1;
    isUnmatchedPossible = isUnmatchedPossible && !isAlways;
    // a production without a condition always matches: later productions have no effect
    if (isAlways && !isWeighted_) {
      break;
    }
  }
  // the general way decides about an unmatched module
  if (isUnmatchedPossible && !isDecomposition_ &&
      (isLeftToDecomposition(system, type) || program.nameOf(type) == "%")) {
    problem_ = "decomposition or the cut symbol decides about a module to which no production applies";
    return false;
  }
  BatchGroup group;
  group.isWeighted = isWeighted_;
  group.firstRule = static_cast<std::uint32_t>(rules_.size());
  group.ruleCount = static_cast<std::uint32_t>(made.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    addRule(program, std::move(made[i]));
    group.looksLeft = group.looksLeft || rules_.back().left != core::kNoModuleType;
    group.looksRight = group.looksRight || rules_.back().right != core::kNoModuleType;
    candidateBits_[type] = static_cast<std::uint8_t>(i == 0 ? bitOf(i) : candidateBits_[type] | bitOf(i));
  }
  group.isLight = !isDecomposition_ && isLight(plan, plan[type]);
  sharePlaces(group);
  if (!rules.isRing()) {
    startNear(group);
  }
  findThresholds(group);
  largestRuleCount_ = std::max<std::size_t>(largestRuleCount_, made.size());
  classes_[type] = Class::Group;
  indices_[type] = static_cast<std::uint32_t>(groups_.size());
  groups_.push_back(std::move(group));
  return true;
}

bool BatchPlan::compile(const language::Program& program, const language::LSystem& system, const Production& production,
                        BatchRule& rule) {
  rule.production = &production;
  if (!production.newLeftContext.empty() || !production.newRightContext.empty()) {
    problem_ = "it looks at the string that is being produced";
    return false;
  }
  if (std::any_of(
          production.successor.begin(), production.successor.end(),
          [&](const language::SuccessorModule& module) { return isLeftToDecomposition(system, module.type); })) {
    problem_ = "decomposition applies to its successor";
    return false;
  }
  ColumnCompiler columns(program, production);
  rule.statics = columns.locals();
  // the pieces in the order in which they run
  const auto take = [&](std::optional<ColumnCode> code, ColumnCode& target) {
    problem_ = code ? problem_ : columns.problem();
    target = code ? std::move(*code) : ColumnCode{};
    return code.has_value();
  };
  const bool mayDraw = !isDecomposition_ && program.compatibility == core::Compatibility::Espalier;
  if (!take(columns.block(production.preBlock, mayDraw), rule.before)) {
    return false;
  }
  const std::vector<bool> assignedBefore = columns.assigned();
  if (production.condition && !take(columns.expression(*production.condition, mayDraw), rule.condition.emplace())) {
    return false;
  }
  rule.weight.result.constant = 1.0;
  if (isWeighted_ && production.probability &&
      !take(columns.expression(*production.probability, mayDraw), rule.weight)) {
    return false;
  }
  if (!take(columns.block(production.postBlock, mayDraw), rule.behind)) {
    return false;
  }
  std::vector<bool> isRead(columns.columnCount(), false);
  addReads(rule.weight, isRead.size(), isRead);
  addReads(rule.behind, isRead.size(), isRead);
  for (const language::Expression& expression : production.expressions) {
    if (!take(columns.expression(expression, mayDraw), rule.values.emplace_back())) {
      return false;
    }
    addReads(rule.values.back(), isRead.size(), isRead);
  }
  for (std::uint32_t column = 0; column < isRead.size(); ++column) {
    if (isRead[column] && assignedBefore[column]) {
      rule.kept.push_back(column);
    }
  }
  rule.drawsRandom =
      rule.before.drawsRandom || (rule.condition && rule.condition->drawsRandom) || rule.weight.drawsRandom ||
      rule.behind.drawsRandom ||
      std::any_of(rule.values.begin(), rule.values.end(), [](const ColumnCode& value) { return value.drawsRandom; });
  if (isDecomposition_ && (hasContexts(production) || production.predecessor.size() > 1)) {
    problem_ = "a decomposition has contexts or a predecessor of several modules";
    return false;
  }
  rule.hasBefore = !production.preBlock.empty();
  rule.hasBehind = !production.postBlock.empty();
  rule.drawsAgain = rule.hasBefore && (rule.before.drawsRandom || (rule.condition && rule.condition->drawsRandom));
  return true;
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

void BatchPlan::addBlock(const std::vector<core::ModuleTypeId>& types, std::uint32_t valueCount,
                         std::uint32_t readModules, std::uint32_t readParameters) {
  BatchBlock block;
  block.length = static_cast<std::uint32_t>(types.size());
  block.valueCount = valueCount;
  block.readModules = readModules;
  block.readParameters = readParameters;
  block.moduleGrowth = static_cast<std::int32_t>(types.size()) - static_cast<std::int32_t>(readModules);
  block.parameterGrowth = static_cast<std::int32_t>(valueCount) - static_cast<std::int32_t>(readParameters);
  block.isResizing = block.moduleGrowth != 0 || block.parameterGrowth != 0 || readModules > 1;
  std::copy_n(types.begin(), std::min(types.size(), block.types.size()), block.types.begin());
  blocks_.push_back(block);
  blockTypes_.push_back(types);
}

void BatchPlan::bindSlots(const language::Program& program, const ContextRules& rules, BatchRule& rule) const {
  const Production& production = *rule.production;
  if (hasContexts(production) || production.predecessor.size() > 1) {
    rule.context = !rules.isRing() && production.predecessor.size() == 1 && isNear(production.leftContext) &&
                           isNear(production.rightContext)
                       ? BatchRule::Context::Near
                       : BatchRule::Context::Searched;
  }
  rule.slots.resize(production.slotCount);
  const auto bind = [&](const language::FormalModule& module, SlotSource::Kind kind, std::uint32_t first,
                        std::uint32_t element = 0) {
    for (std::uint32_t i = 0; i < program.arity[module.type]; ++i) {
      rule.slots[module.firstSlot + i] = {kind, first + i, element};
    }
  };
  std::uint32_t first = 0;
  for (const language::FormalModule& module : production.predecessor) {
    bind(module, SlotSource::Kind::Own, first);
    first += program.arity[module.type];
  }
  if (rule.context == BatchRule::Context::Near) {
    if (!production.leftContext.empty()) {
      rule.left = production.leftContext[0].module.type;
      bind(production.leftContext[0].module, SlotSource::Kind::Left, 0);
    }
    if (!production.rightContext.empty()) {
      rule.right = production.rightContext[0].module.type;
      bind(production.rightContext[0].module, SlotSource::Kind::Right, 0);
    }
  }
  if (rule.context == BatchRule::Context::Searched) {
    std::uint32_t element = 0;
    for (const std::vector<ContextElement>* context : {&production.leftContext, &production.rightContext}) {
      for (const ContextElement& sought : *context) {
        if (sought.kind != ContextElement::Kind::SkipToBranchEnd) {
          bind(sought.module, SlotSource::Kind::Searched, 0, element);
        }
        ++element;
      }
    }
  }
}

void BatchPlan::addRule(const language::Program& program, BatchRule rule) {
  const Production& production = *rule.production;
  std::vector<core::ModuleTypeId> types;
  for (const language::SuccessorModule& module : production.successor) {
    types.push_back(module.type);
  }
  std::uint32_t readParameters = 0;
  for (const language::FormalModule& module : production.predecessor) {
    readParameters += program.arity[module.type];
  }
  rule.block = static_cast<std::uint32_t>(blocks_.size());
  addBlock(types, static_cast<std::uint32_t>(rule.values.size()),
           static_cast<std::uint32_t>(production.predecessor.size()), readParameters);
  rule.changesParts = !blocks_.back().isResizing && types[0] != production.predecessor[0].type;
  rule.needsLanes = !rule.values.empty() || rule.changesParts || rule.hasBehind;

  largestSlotCount_ = std::max<std::size_t>(largestSlotCount_, production.slotCount);
  largestKeptCount_ = std::max(largestKeptCount_, rule.kept.size());
  hasBlocks_ = hasBlocks_ || rule.hasBefore || rule.hasBehind;
  drawsRandom_ = drawsRandom_ || rule.drawsRandom;
  const auto addColumns = [this](const ColumnCode& code) {
    largestColumnCount_ = std::max<std::size_t>(largestColumnCount_, code.columnCount);
  };
  addColumns(rule.before);
  addColumns(rule.condition.value_or(ColumnCode{}));
  addColumns(rule.weight);
  addColumns(rule.behind);
  std::for_each(rule.values.begin(), rule.values.end(), addColumns);
  rules_.push_back(std::move(rule));
}

void BatchPlan::sharePlaces(const BatchGroup& group) {
  // the choice by weight asks the rules twice, for different modules
  if (group.isWeighted) {
    return;
  }
  BatchRule* searched = nullptr;  // the last that keeps what it finds
  for (std::uint32_t i = group.firstRule; i < group.firstRule + group.ruleCount; ++i) {
    BatchRule& rule = rules_[i];
    if (rule.context != BatchRule::Context::Searched) {
      continue;
    }
    if (searched != nullptr && findSamePlaces(*searched->production, *rule.production)) {
      searched->keepsPlaces = true;
      rule.sharesPlaces = true;
    } else {
      searched = &rule;
    }
  }
}

/// Two rules whose searches begin at the nearest module on a side need it once.
void BatchPlan::startNear(BatchGroup& group) {
  const auto decide = [&](bool& looks, bool BatchRule::*starts, std::vector<ContextElement> Production::*context) {
    std::size_t count = looks ? 1 : 0;
    const auto canStart = [&](const BatchRule& rule) {
      const std::vector<ContextElement>& elements = rule.production->*context;
      return rule.context == BatchRule::Context::Searched && !rule.sharesPlaces &&
             rule.production->predecessor.size() == 1 && !elements.empty() &&
             elements[0].kind == ContextElement::Kind::Module;
    };
    const std::span<BatchRule> rules(rules_.data() + group.firstRule, group.ruleCount);
    count += static_cast<std::size_t>(std::count_if(rules.begin(), rules.end(), canStart));
    if (count < 2) {
      return;
    }
    for (BatchRule& rule : rules) {
      rule.*starts = canStart(rule);
      looks = looks || rule.*starts;
      group.keepsModules = group.keepsModules || rule.*starts;
    }
  };
  decide(group.looksLeft, &BatchRule::startsLeft, &Production::leftContext);
  decide(group.looksRight, &BatchRule::startsRight, &Production::rightContext);
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
    if (rule.context != BatchRule::Context::None || rule.condition || rule.hasBefore ||
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
          if (canStandBefore(production, other, isOpen)) {
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
  for (const BatchGroup& group : groups_) {
    for (std::uint32_t k = 0; k < group.ruleCount; ++k) {
      rules_[group.firstRule + k].mark = bitOf(k);
    }
  }
  if (!hasPairs_) {
    return;
  }
  // one table for each side instead of pairs: rules have marks of their own as far as there are marks
  const auto markOf = [](std::size_t rule) { return static_cast<std::uint8_t>(1U << (rule % kRuleMarks)); };
  needsPairBits_ = rules_.size() > kRuleMarks;
  for (std::size_t i = 0; i < rules_.size() && !needsPairBits_; ++i) {
    rules_[i].mark = markOf(i);
  }
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
      if (rules.isIgnored(type) || canBeNext(production.leftContext, type, isOpen || type == program.closeBranch)) {
        siteMarks_.before[i] |= markOf(rule);
      }
      if (rules.isIgnored(type) || canStandBefore(production, type, isOpen)) {
        siteMarks_.behind[i] |= markOf(rule);
      }
    }
  }
}

}  // namespace espalier::derivation

#include "engine/derivation/scan/plain_scan.h"

#include <algorithm>
#include <cstring>

#include "engine/derivation/batch/fixed_blocks.h"

namespace espalier::derivation {
namespace {

// the most old modules between two looks at the limits and at `cancelled`
constexpr std::uint64_t kMostModules = 4096;
// the most new modules or parameters between two looks at the limits
constexpr std::uint64_t kMostOutput = 65536;
// modules or parameters that a move may write beyond the end
constexpr std::uint64_t kSlack = 64;
// parameters that one move copies, even when fewer count
constexpr std::uint64_t kCopiedAtOnce = ProductionPlan::kFreePlaces;

}  // namespace

PlainScan::PlainScan(ScanContext& context, ModuleRewriter& rewriter)
    : context_(&context),
      rewriter_(&rewriter),
      plans_(context.tables.front().plan.plans()),
      rules_(context.tables.front().plan.rules()),
      values_(context.tables.front().plan.values()),
      successors_(context.tables.front().plan.types()),
      storesFloats_(context.rewriter.storesFloats()),
      frame_(context.tables.front().plan.firstConstant(), 0.0) {
  const std::vector<std::uint16_t>& arity = context.program.arity;
  hasParameters_ = std::any_of(arity.begin(), arity.end(), [](std::uint16_t count) { return count > 0; });
  const ProductionPlan& plan = context.tables.front().plan;
  frame_.insert(frame_.end(), plan.constants().begin(), plan.constants().end());
  chunkModules_ = std::clamp<std::uint64_t>(kMostOutput / std::max(plan.largestLength(), plan.largestParameterCount()),
                                            1, kMostModules);
}

void PlainScan::run(std::uint64_t end, ScanPlace& place) {
  if (context_->drawsEachPosition(*context_->tables.front().system)) {
    hasParameters_ ? scan<true, true>(end, place) : scan<true, false>(end, place);
  } else {
    hasParameters_ ? scan<false, true>(end, place) : scan<false, false>(end, place);
  }
}

template <bool kDrawsEachPosition, bool kHasParameters>
void PlainScan::scan(std::uint64_t end, ScanPlace& place) {
  while (place.module < end) {
    context_->evaluator.clearModule();
    context_->evaluator.pollCancelled();
    context_->rewriter.checkSize(context_->output.size(), context_->output.parameterCount());
    const ScanPlace begin = place;
    const std::uint64_t modules = context_->output.size();
    const std::uint64_t parameters = context_->output.parameterCount();
    scanChunk<kDrawsEachPosition, kHasParameters>(std::min(end, place.module + chunkModules_), place);
    context_->noteEqualEnds(begin, place, modules, parameters);
  }
}

PlainScan::Target PlainScan::startWriting(std::uint64_t moduleCount) {
  const ProductionPlan& plan = context_->tables.front().plan;
  ModuleString& output = context_->output;
  const std::uint64_t modules = output.size() + moduleCount * plan.largestLength();
  const std::uint64_t parameters = output.parameterCount() + moduleCount * plan.largestParameterCount();
  isNearLimits_ = !context_->isWithinLimits(modules, parameters);
  context_->reserveOutput(modules + kSlack, parameters + kSlack);
  return {output.typeBuffer().data() + output.size(), output.parameterBuffer().data() + output.parameterCount()};
}

void PlainScan::stopWriting(const Target& target) {
  ModuleString& output = context_->output;
  output.typeBuffer().resize(static_cast<std::size_t>(target.type - output.typeBuffer().data()));
  output.parameterBuffer().resize(static_cast<std::size_t>(target.parameter - output.parameterBuffer().data()));
}

[[gnu::always_inline]] inline void PlainScan::loadFrame(const ModuleString& old, std::uint64_t offset,
                                                        std::uint64_t arity, std::uint32_t firstSlot) {
  double* const slots = frame_.data() + firstSlot;
  const double* const parameters = old.parameters().data() + offset;
  if (arity <= kCopiedAtOnce && offset + kCopiedAtOnce <= old.parameterCount()) [[likely]] {
    std::memcpy(slots, parameters, kCopiedAtOnce * sizeof(double));
  } else {
    std::copy_n(parameters, arity, slots);
  }
}

[[gnu::always_inline]] inline double PlainScan::evaluate(const QuickValue& value) {
  return value.form == QuickValue::Form::Code ? context_->evaluator.value(*value.expression, frame_.data())
                                              : quickValue(value, frame_.data());
}

[[gnu::always_inline]] inline const QuickRule* PlainScan::chooseRule(const TypePlan& plan, core::ModuleTypeId type,
                                                                     std::uint64_t module, double draw) {
  if (plan.usesCode) {
    context_->evaluator.setModule(module, type);
    if (plan.drawsRandom) {
      context_->random.key(core::DrawDomain::Production, context_->step, module);
    }
  }
  const QuickRule* const first = rules_ + plan.firstRule;
  const QuickRule* const last = first + plan.ruleCount;
  if (plan.kind == TypePlan::Kind::Weights) {
    return chooseByWeights(first, last, module, draw);
  }
  for (const QuickRule* rule = first; rule != last; ++rule) {
    if (!rule->hasCondition || evaluate(rule->condition) != 0.0) {
      return rule;
    }
  }
  return nullptr;
}

[[gnu::always_inline]] inline void PlainScan::writeSuccessor(const QuickRule& rule, std::uint64_t module,
                                                             Target& target) {
  const core::ModuleTypeId* const successor = successors_ + rule.firstType;
  if (rule.length <= TypePlan::kInlineTypes) [[likely]] {
    std::memcpy(target.type, successor, TypePlan::kInlineTypes * sizeof(core::ModuleTypeId));
  } else {
    std::memcpy(target.type, successor, rule.length * sizeof(core::ModuleTypeId));
  }
  target.type += rule.length;
  const QuickValue* value = values_ + rule.firstValue;
  for (std::uint32_t i = 0; i < rule.valueCount; ++i, ++value) {
    const double result = evaluate(*value);
    if (storesFloats_) {
      *target.parameter++ = static_cast<double>(static_cast<float>(result));
    } else if (result - result == 0.0) [[likely]] {
      *target.parameter++ = result;
    } else {
      failNonFinite(rule, i, result, module);
    }
  }
}

template <bool kHasParameters>
[[gnu::always_inline]] inline void PlainScan::writeFixed(const TypePlan& plan, const ModuleString& old,
                                                         std::uint64_t offset, Target& target) {
  std::memcpy(target.type, plan.types.data(), sizeof(plan.types));
  if (plan.length > TypePlan::kInlineTypes) [[unlikely]] {
    std::memcpy(target.type, successors_ + plan.firstType, plan.length * sizeof(core::ModuleTypeId));
  }
  target.type += plan.length;
  if constexpr (kHasParameters) {
    const double* const parameters = old.parameters().data() + offset;
    if (plan.arity <= kCopiedAtOnce && offset + kCopiedAtOnce <= old.parameterCount()) [[likely]] {
      std::memcpy(target.parameter, parameters, kCopiedAtOnce * sizeof(double));
    } else if (plan.copied > 0) {
      std::memcpy(target.parameter, parameters, plan.copied * sizeof(double));
    }
    target.parameter += plan.copied;
  }
}

template <bool kDrawsEachPosition, bool kHasParameters>
void PlainScan::scanChunk(std::uint64_t end, ScanPlace& place) {
  const SystemTables& tables = context_->tables.front();
  const TypePlan* const plans = plans_;
  const ModuleString& old = *context_->old;
  const core::ModuleTypeId* types = old.types().data();
  const double* parameters = old.parameters().data();
  std::uint64_t module = place.module;
  std::uint64_t offset = place.offset;
  Target target = startWriting(end - module);
  // two modules at a time, where every module becomes the same block each time
  if constexpr (!kDrawsEachPosition && !kHasParameters) {
    if (const FixedBlocks& blocks = tables.batches.fixedBlocks(); blocks.hasTable()) {
      const core::Buffer<core::ModuleTypeId>& reserved = context_->output.typeBuffer();
      target.type = blocks.write(types + module, end - module, target.type, reserved.data() + reserved.capacity());
      module = end;
    }
  }
  while (module < end) {
    const TypePlan& plan = plans[types[module]];
    double draw = 0.0;
    if constexpr (kDrawsEachPosition) {
      draw = context_->random.selection(context_->step, module);
    }

    // the same modules every time: written whole, however many of them count
    if (plan.kind == TypePlan::Kind::Fixed) [[likely]] {
      writeFixed<kHasParameters>(plan, old, offset, target);
      offset += kHasParameters ? plan.arity : 0;
      ++module;
      continue;
    }

    if (plan.kind == TypePlan::Kind::BlocksOrContexts || plan.kind == TypePlan::Kind::General) {
      stopWriting(target);
      ScanPlace next{module, offset};
      if (plan.kind == TypePlan::Kind::BlocksOrContexts) {
        scanInFull(end, draw, next);
      } else {
        scanGeneral(end, draw, next);
      }
      module = next.module;
      offset = next.offset;
      target = startWriting(end > module ? end - module : 0);
      continue;
    }

    // productions that only a condition and a weight decide between
    loadFrame(old, offset, plan.arity, 0);
    const QuickRule* const rule = chooseRule(plan, types[module], module, draw);
    if (rule != nullptr) {
      writeSuccessor(*rule, module, target);
    } else {
      // no production applies: the module stands for itself
      *target.type++ = types[module];
      target.parameter = std::copy_n(parameters + offset, plan.arity, target.parameter);
    }
    offset += plan.arity;
    ++module;
  }
  stopWriting(target);
  place = {module, offset};
}

void PlainScan::scanInFull(std::uint64_t end, double draw, ScanPlace& place) {
  const ModuleString& old = *context_->old;
  const core::ModuleTypeId* const types = old.types().data();
  const bool drawsEachPosition = context_->drawsEachPosition(*context_->tables.front().system);
  Target target = startWriting(end - place.module);
  const TypePlan* plan = &plans_[types[place.module]];
  while (true) {
    if (plan->kind == TypePlan::Kind::Fixed) {
      writeFixed<true>(*plan, old, place.offset, target);
    } else {
      rewriteInFull(*plan, place, draw, target);
    }
    place.module += 1;
    place.offset += plan->arity;
    if (place.module == end) {
      break;
    }
    plan = &plans_[types[place.module]];
    if (plan->kind != TypePlan::Kind::BlocksOrContexts && plan->kind != TypePlan::Kind::Fixed) {
      break;
    }
    draw = drawsEachPosition ? context_->random.selection(context_->step, place.module) : 0.0;
  }
  stopWriting(target);
}

bool PlainScan::matchesContexts(const QuickRule& rule, ScanPlace place, std::uint64_t arity) {
  const language::Production& production = *rule.production;
  loadFrame(*context_->old, place.offset, arity, production.predecessor[0].firstSlot);
  if (!rule.hasContexts) {
    return true;
  }
  const ContextString& around = context_->rewriter.around();
  const ContextRules& rules = context_->tables.front().rules;
  return (production.rightContext.empty() || matchesRight(context_->program, rules, around, production.rightContext,
                                                          place.module + 1, place.offset + arity, frame_.data())) &&
         (production.leftContext.empty() || matchesLeft(context_->program, rules, around, production.leftContext,
                                                        place.module, place.offset, frame_.data()));
}

bool PlainScan::matches(const QuickRule& rule) {
  if (rule.hasBefore) {
    context_->evaluator.run(rule.production->preBlock, frame_.data());
  }
  return !rule.hasCondition || evaluate(rule.condition) != 0.0;
}

void PlainScan::scanGeneral(std::uint64_t end, double draw, ScanPlace& place) {
  const core::ModuleTypeId* const types = context_->old->types().data();
  const SystemTables& tables = context_->tables.front();
  const bool drawsEachPosition = context_->drawsEachPosition(*tables.system);
  while (true) {
    rewriter_->rewriteNext(tables, draw, place);
    context_->rewriter.checkSize(context_->output.size(), context_->output.parameterCount());
    if (place.module >= end || plans_[types[place.module]].kind != TypePlan::Kind::General) {
      return;
    }
    draw = drawsEachPosition ? context_->random.selection(context_->step, place.module) : 0.0;
  }
}

void PlainScan::rewriteInFull(const TypePlan& plan, ScanPlace place, double draw, Target& target) {
  const ModuleString& old = *context_->old;
  const core::ModuleTypeId type = old.types()[place.module];
  const double* const parameters = old.parameters().data() + place.offset;
  context_->evaluator.setModule(place.module, type);
  if (plan.drawsRandom) {
    context_->random.key(core::DrawDomain::Production, context_->step, place.module);
  }
  const QuickRule* const first = rules_ + plan.firstRule;
  const QuickRule* const last = first + plan.ruleCount;
  const QuickRule* rule = nullptr;
  if (context_->tables.front().system->isStochastic) {
    loadFrame(old, place.offset, plan.arity, 0);
    rule = chooseByWeights(first, last, place.module, draw);
  } else {
    for (const QuickRule* candidate = first; candidate != last && rule == nullptr; ++candidate) {
      rule = matchesContexts(*candidate, place, plan.arity) && matches(*candidate) ? candidate : nullptr;
    }
  }
  if (rule == nullptr) {
    *target.type++ = type;
    target.parameter = std::copy_n(parameters, plan.arity, target.parameter);
  } else {
    if (rule->hasBehind) {
      context_->evaluator.run(rule->production->postBlock, frame_.data());
    }
    writeSuccessor(*rule, place.module, target);
  }
  // effects of blocks can be seen, so none runs behind a module that exceeds a limit
  if (isNearLimits_) [[unlikely]] {
    context_->rewriter.checkSize(static_cast<std::uint64_t>(target.type - context_->output.types().data()),
                                 static_cast<std::uint64_t>(target.parameter - context_->output.parameters().data()));
  }
}

const QuickRule* PlainScan::chooseByWeights(const QuickRule* first, const QuickRule* last, std::uint64_t module,
                                            double draw) {
  // the weights of the rules whose condition holds
  weights_.clear();
  matching_.clear();
  double sum = 0.0;
  for (const QuickRule* rule = first; rule != last; ++rule) {
    if (matches(*rule)) {
      const double weight = evaluate(rule->weight);
      weights_.push_back(weight);
      matching_.push_back(rule);
      sum += weight;
    }
  }
  if (matching_.size() < 2) {
    return matching_.empty() ? nullptr : matching_.front();
  }
  if (!storesFloats_ && !(sum - sum == 0.0)) {
    context_->rewriter.failWeights(*matching_.front()->production);
  }
  return matching_[chooseByWeight(
      weights_, storesFloats_ ? draw : 1.0 - context_->random.selection(context_->step, module), storesFloats_)];
}

void PlainScan::failNonFinite(const QuickRule& rule, std::uint32_t valueIndex, double value, std::uint64_t module) {
  // which parameter of which module of the successor it is
  context_->evaluator.setModule(module, context_->old->types()[module]);
  std::uint32_t remaining = valueIndex;
  for (const language::SuccessorModule& made : rule.production->successor) {
    const std::uint32_t arity = context_->program.arity[made.type];
    if (remaining < arity) {
      context_->rewriter.failNonFinite(value, rule.production->expressions[made.firstExpression + remaining], remaining,
                                       made.type);
    }
    remaining -= arity;
  }
  context_->evaluator.failHere(core::SimulationErrorCode::NonFinite, "a parameter is not finite");
}

}  // namespace espalier::derivation

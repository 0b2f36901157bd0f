#include "engine/derivation/matching/production_plan.h"

#include <algorithm>

#include "engine/language/arithmetic.h"

namespace espalier::derivation {
namespace {

using language::Expression;
using language::Instruction;
using language::Operation;
using language::Production;

/// Operators that never warn, so that they need no Evaluator.
bool isQuickOperator(Operation operation, bool isDivisorSafe) {
  switch (operation) {
    case Operation::Add:
    case Operation::Subtract:
    case Operation::Multiply:
    case Operation::Equal:
    case Operation::NotEqual:
    case Operation::Less:
    case Operation::LessEqual:
    case Operation::Greater:
    case Operation::GreaterEqual:
      return true;
    case Operation::Divide:
      return isDivisorSafe;
    default:
      return false;
  }
}

/// Whether code assigns a formal parameter.
bool assignsFormal(const language::Program& program, const language::CodeRange& code) {
  return std::any_of(program.code.begin() + code.begin, program.code.begin() + code.end,
                     [](const Instruction& instruction) { return instruction.operation == Operation::StoreSlot; });
}

/// Whether only contexts, condition and weight decide, and the successor stays as it is made. All candidates of a
/// module share its formal parameters, so no block that runs before the choice may assign one. Where weights decide,
/// several candidates match, and each needs the parameters of its own contexts.
bool isQuickProduction(const language::Program& program, const language::LSystem& system,
                       const Production& production) {
  if (production.predecessor.size() != 1 || (!hasContexts(production) && production.predecessor[0].firstSlot != 0) ||
      (hasContexts(production) && system.isStochastic) || !production.newLeftContext.empty() ||
      !production.newRightContext.empty() || assignsFormal(program, production.preBlock)) {
    return false;
  }
  return std::none_of(
      production.successor.begin(), production.successor.end(),
      [&](const language::SuccessorModule& module) { return system.decomposition.mayApplyTo(module.type); });
}

bool canDraw(const Expression& expression) {
  return !expression.isPure;
}

/// Whether a block calls what is not pure: draws, `srand`.
bool canDraw(const language::Program& program, const language::CodeRange& block) {
  return std::any_of(program.code.begin() + block.begin, program.code.begin() + block.end,
                     [](const Instruction& instruction) {
                       return instruction.operation == Operation::Call &&
                              !language::functionInfo(static_cast<language::Function>(instruction.operand)).isPure;
                     });
}

bool isCode(const QuickValue& value) {
  return value.form == QuickValue::Form::Code;
}

/// Symbols that the scan does not simply copy when no production applies.
bool isScanSymbol(const language::Program& program, core::ModuleTypeId type) {
  return program.nameOf(type) == "%";
}

}  // namespace

bool hasContexts(const Production& production) {
  return !production.leftContext.empty() || !production.rightContext.empty();
}

std::size_t chooseByWeight(std::span<const double> weights, double draw, bool usesFloats) {
  if (usesFloats) {
    float sum = 0.0F;
    for (const double weight : weights) {
      sum = static_cast<float>(static_cast<double>(sum) + weight);
    }
    auto remainder = static_cast<float>(static_cast<double>(sum) * draw);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      remainder = static_cast<float>(static_cast<double>(remainder) - weights[i]);
      if (remainder <= 0.0F) {
        return i;
      }
    }
    return weights.size() - 1;
  }
  double sum = 0.0;
  for (const double weight : weights) {
    sum += weight;
  }
  double remainder = sum * draw;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    remainder -= weights[i];
    if (remainder <= 0.0) {
      return i;
    }
  }
  return weights.size() - 1;
}

ProductionPlan::ProductionPlan(const language::Program& program, const language::LSystem& system)
    : plans_(program.moduleTypeCount()), firstConstant_(program.maximumSlots + kFreePlaces) {
  for (std::size_t type = 0; type < program.moduleTypeCount(); ++type) {
    planType(program, system, static_cast<core::ModuleTypeId>(type));
  }
  types_.resize(types_.size() + TypePlan::kInlineTypes, 0);
}

void ProductionPlan::makeFixed(TypePlan& plan, std::uint32_t firstType, std::uint32_t length) {
  plan.kind = TypePlan::Kind::Fixed;
  plan.firstType = firstType;
  plan.length = length;
  std::copy_n(types_.data() + firstType, std::min<std::size_t>(length, TypePlan::kInlineTypes), plan.types.begin());
  largestLength_ = std::max<std::uint64_t>(largestLength_, length);
  largestParameterCount_ = std::max<std::uint64_t>(largestParameterCount_, plan.copied);
}

void ProductionPlan::planType(const language::Program& program, const language::LSystem& system,
                              core::ModuleTypeId type) {
  TypePlan& plan = plans_[type];
  plan.arity = program.arity[type];
  const std::span<const std::uint32_t> candidates =
      system.productions.index.empty() ? std::span<const std::uint32_t>{} : system.productions.index.candidates(type);
  const bool standsForItself = !system.decomposition.mayApplyTo(type) && !isScanSymbol(program, type);

  // no production: the module is copied
  if (candidates.empty()) {
    if (standsForItself) {
      plan.copied = plan.arity;
      types_.push_back(type);
      makeFixed(plan, static_cast<std::uint32_t>(types_.size() - 1), 1);
    }
    return;
  }
  const bool isQuick = std::all_of(candidates.begin(), candidates.end(), [&](std::uint32_t index) {
    return isQuickProduction(program, system, system.productions.productions[index]);
  });
  if (!isQuick) {
    return;
  }
  plan.firstRule = static_cast<std::uint32_t>(rules_.size());
  bool isUnmatchedPossible = true;
  bool hasMore = false;  // blocks or contexts
  for (const std::uint32_t index : candidates) {
    const Production& production = system.productions.productions[index];
    plan.ruleCount += addRule(program, production, system.isStochastic);
    const QuickRule& rule = rules_.back();
    plan.drawsRandom = plan.drawsRandom || (production.condition && canDraw(*production.condition)) ||
                       (rule.hasWeight && canDraw(*production.probability)) ||
                       std::any_of(production.expressions.begin(), production.expressions.end(),
                                   [](const Expression& expression) { return canDraw(expression); }) ||
                       canDraw(program, production.preBlock) || canDraw(program, production.postBlock);
    hasMore = hasMore || rule.hasBefore || rule.hasBehind || rule.hasContexts;
    plan.usesCode = plan.usesCode || hasMore || isCode(rule.condition) || isCode(rule.weight) ||
                    std::any_of(values_.begin() + rule.firstValue, values_.end(), isCode);
    isUnmatchedPossible = isUnmatchedPossible && (rule.hasCondition || rule.hasContexts);
    // a production without a condition always matches: later productions have no effect
    if (!system.isStochastic && !rule.hasCondition && !rule.hasContexts) {
      break;
    }
  }
  // the general way decides about an unmatched module
  if (isUnmatchedPossible && !standsForItself) {
    plan.kind = TypePlan::Kind::General;
    return;
  }
  plan.kind = hasMore               ? TypePlan::Kind::BlocksOrContexts
              : system.isStochastic ? TypePlan::Kind::Weights
                                    : TypePlan::Kind::Rules;
  const QuickRule& first = rules_[plan.firstRule];
  if (plan.ruleCount == 1 && !first.hasCondition && !first.hasWeight && !hasMore && first.valueCount == 0) {
    makeFixed(plan, first.firstType, first.length);
    return;
  }
  for (std::uint32_t i = 0; i < plan.ruleCount; ++i) {
    const QuickRule& rule = rules_[plan.firstRule + i];
    largestLength_ = std::max<std::uint64_t>(largestLength_, rule.length);
    largestParameterCount_ = std::max<std::uint64_t>(largestParameterCount_, rule.valueCount);
  }
  largestParameterCount_ = std::max<std::uint64_t>(largestParameterCount_, plan.arity);
}

std::uint32_t ProductionPlan::addConstant(double value) {
  constants_.push_back(value);
  return static_cast<std::uint32_t>(firstConstant_ + constants_.size() - 1);
}

QuickValue ProductionPlan::makeValue(const language::Program& program, const Expression& expression) {
  QuickValue value;
  value.expression = &expression;
  value.form = QuickValue::Form::Code;
  switch (expression.kind) {
    case Expression::Kind::Constant:
      value.form = QuickValue::Form::Constant;
      value.a = addConstant(expression.constant);
      return value;
    case Expression::Kind::Slot:
      value.form = QuickValue::Form::Slot;
      value.a = expression.slot;
      return value;
    case Expression::Kind::Code:
      break;
  }
  if (expression.code.end - expression.code.begin != 3) {
    return value;
  }
  // two operands, of which one may be a constant, and an operator
  const Instruction& first = program.code[expression.code.begin];
  const Instruction& second = program.code[expression.code.begin + 1];
  const Operation operation = program.code[expression.code.begin + 2].operation;
  const auto isOperand = [](const Instruction& instruction) {
    return instruction.operation == Operation::LoadSlot || instruction.operation == Operation::Constant;
  };
  const bool isSecondConstant = second.operation == Operation::Constant;
  if (!isOperand(first) || !isOperand(second) || (first.operation == Operation::Constant && isSecondConstant) ||
      !isQuickOperator(operation, isSecondConstant && program.constants[second.operand] != 0.0)) {
    return value;
  }
  const auto place = [&](const Instruction& instruction) {
    return instruction.operation == Operation::LoadSlot ? instruction.operand
                                                        : addConstant(program.constants[instruction.operand]);
  };
  value.form = QuickValue::Form::Operator;
  value.operation = operation;
  value.a = place(first);
  value.b = place(second);
  return value;
}

std::uint32_t ProductionPlan::addRule(const language::Program& program, const Production& production,
                                      bool usesWeights) {
  QuickRule rule;
  rule.production = &production;
  rule.hasContexts = hasContexts(production);
  rule.hasBefore = !production.preBlock.empty();
  rule.hasBehind = !production.postBlock.empty();
  rule.hasCondition = production.condition.has_value();
  if (rule.hasCondition) {
    rule.condition = makeValue(program, *production.condition);
  }
  rule.hasWeight = usesWeights && production.probability.has_value();
  rule.weight.a = addConstant(1.0);
  if (rule.hasWeight) {
    rule.weight = makeValue(program, *production.probability);
  }
  rule.firstType = static_cast<std::uint32_t>(types_.size());
  rule.length = static_cast<std::uint32_t>(production.successor.size());
  rule.firstValue = static_cast<std::uint32_t>(values_.size());
  for (const language::SuccessorModule& module : production.successor) {
    types_.push_back(module.type);
    for (std::uint32_t i = 0; i < program.arity[module.type]; ++i) {
      values_.push_back(makeValue(program, production.expressions[module.firstExpression + i]));
    }
  }
  rule.valueCount = static_cast<std::uint32_t>(values_.size()) - rule.firstValue;
  rules_.push_back(rule);
  return 1;
}

}  // namespace espalier::derivation

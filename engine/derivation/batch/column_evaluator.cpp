#include "engine/derivation/batch/column_evaluator.h"

#include <array>

#include "engine/language/arithmetic.h"

namespace espalier::derivation {
namespace {

using language::Function;
using language::Instruction;
using language::Operation;

/// target[i] = f(a[i], b[i]). There is a loop without branches for each side that may be the same for all lanes.
template <typename F>
void forEach(double* target, const ColumnValue& a, const ColumnValue& b, std::size_t count, F f) {
  if (a.values != nullptr && b.values != nullptr) {
    for (std::size_t i = 0; i < count; ++i) {
      target[i] = f(a.values[i], b.values[i]);
    }
  } else if (a.values != nullptr) {
    for (std::size_t i = 0; i < count; ++i) {
      target[i] = f(a.values[i], b.constant);
    }
  } else if (b.values != nullptr) {
    for (std::size_t i = 0; i < count; ++i) {
      target[i] = f(a.constant, b.values[i]);
    }
  } else {
    const double value = f(a.constant, b.constant);
    for (std::size_t i = 0; i < count; ++i) {
      target[i] = value;
    }
  }
}

double at(const ColumnValue& value, std::size_t i) {
  return value.values == nullptr ? value.constant : value.values[i];
}

}  // namespace

ColumnEvaluator::ColumnEvaluator(const language::Program& program, std::size_t slotCount, std::size_t columnCount)
    : program_(&program),
      slots_(slotCount * kLanes),
      gathered_(slotCount, 0),
      columns_((columnCount + 1) * kLanes),
      frame_(slotCount + 1),
      stack_(program.maximumStack + std::size_t{8}) {}

void ColumnEvaluator::begin(double step, double length, const std::uint8_t* hasWarned,
                            const core::CounterRandom& draws) {
  draws_ = draws;
  step_ = step;
  length_ = length;
  hasWarned_ = hasWarned;
  isUnusual_ = false;
}

void ColumnEvaluator::setLanes(const Lanes& lanes) {
  lanes_ = lanes;
  ++generation_;
}

const double* ColumnEvaluator::slot(std::uint32_t index) {
  double* column = slots_.data() + index * kLanes;
  if (gathered_[index] == generation_) {
    return column;
  }
  gathered_[index] = generation_;
  const SlotSource source = lanes_.slots[index];
  const auto gather = [&](const double* base, const auto* offsets) {
    base += source.position;
    for (std::size_t i = 0; i < lanes_.count; ++i) {
      column[i] = base[offsets[i]];
    }
  };
  switch (source.kind) {
    case SlotSource::Kind::Own:
      gather(lanes_.ownParameters, lanes_.own);
      break;
    case SlotSource::Kind::Left:
      gather(lanes_.parameters, lanes_.left);
      break;
    case SlotSource::Kind::Right:
      gather(lanes_.parameters, lanes_.right);
      break;
    case SlotSource::Kind::Searched:
      gather(lanes_.rows, lanes_.left);
      break;
  }
  return column;
}

ColumnValue ColumnEvaluator::operand(const ColumnOperand& operand) {
  switch (operand.kind) {
    case ColumnOperand::Kind::Constant:
      break;
    case ColumnOperand::Kind::Slot:
      return {slot(operand.index), 0.0};
    case ColumnOperand::Kind::Column:
      return {columns_.data() + operand.index * kLanes, 0.0};
    case ColumnOperand::Kind::Step:
      return {nullptr, step_};
    case ColumnOperand::Kind::Length:
      return {nullptr, length_};
  }
  return {nullptr, operand.constant};
}

ColumnValue ColumnEvaluator::value(const ColumnExpression& expression) {
  if (expression.isPerLane) {
    double* target = columns_.data();
    runPerLane(expression, target);
    return {target, 0.0};
  }
  for (const ColumnInstruction& instruction : expression.instructions) {
    run(instruction);
  }
  return operand(expression.result);
}

void ColumnEvaluator::run(const ColumnInstruction& instruction) {
  double* target = columns_.data() + instruction.target * kLanes;
  const std::size_t count = lanes_.count;
  const ColumnValue a = operand(instruction.operands[0]);
  const ColumnValue b = instruction.count > 1 ? operand(instruction.operands[1]) : ColumnValue{};
  switch (instruction.operation) {
    case Operation::Add:
      forEach(target, a, b, count, [](double x, double y) { return x + y; });
      return;
    case Operation::Subtract:
      forEach(target, a, b, count, [](double x, double y) { return x - y; });
      return;
    case Operation::Multiply:
      forEach(target, a, b, count, [](double x, double y) { return x * y; });
      return;
    case Operation::Divide: {
      bool dividesByZero = false;
      for (std::size_t i = 0; i < (b.values == nullptr ? 1 : count); ++i) {
        dividesByZero |= at(b, i) == 0.0;
      }
      if (dividesByZero) {
        noteDivision(instruction.instruction);
        forEach(target, a, b, count, [](double x, double y) { return x / (y == 0.0 ? 1.0 : y); });
      } else {
        forEach(target, a, b, count, [](double x, double y) { return x / y; });
      }
      return;
    }
    case Operation::Equal:
      forEach(target, a, b, count, [](double x, double y) { return language::toNumber(x == y); });
      return;
    case Operation::NotEqual:
      forEach(target, a, b, count, [](double x, double y) { return language::toNumber(x != y); });
      return;
    case Operation::Less:
      forEach(target, a, b, count, [](double x, double y) { return language::toNumber(x < y); });
      return;
    case Operation::LessEqual:
      forEach(target, a, b, count, [](double x, double y) { return language::toNumber(x <= y); });
      return;
    case Operation::Greater:
      forEach(target, a, b, count, [](double x, double y) { return language::toNumber(x > y); });
      return;
    case Operation::GreaterEqual:
      forEach(target, a, b, count, [](double x, double y) { return language::toNumber(x >= y); });
      return;
    case Operation::LogicalAnd:
      forEach(target, a, b, count, [](double x, double y) { return language::toNumber((x != 0.0) & (y != 0.0)); });
      return;
    case Operation::LogicalOr:
      forEach(target, a, b, count, [](double x, double y) { return language::toNumber((x != 0.0) | (y != 0.0)); });
      return;
    case Operation::Negate:
    case Operation::Not:
    case Operation::ToBoolean:
      for (std::size_t i = 0; i < count; ++i) {
        target[i] = language::applyUnary(instruction.operation, at(a, i));
      }
      return;
    case Operation::Select: {
      const ColumnValue c = operand(instruction.operands[2]);
      for (std::size_t i = 0; i < count; ++i) {
        target[i] = language::isTrue(at(a, i)) ? at(b, i) : at(c, i);
      }
      return;
    }
    default:
      break;
  }
  // everything else lane by lane, by the function that the Evaluator uses too
  bool dividesByZero = false;
  if (instruction.operation == Operation::Call && static_cast<Function>(instruction.function) == Function::Ran) {
    const auto step = static_cast<std::uint32_t>(step_);
    for (std::size_t i = 0; i < count; ++i) {
      target[i] = at(a, i) * draws_.uniform(core::DrawDomain::Production, step, lanes_.modules[i], instruction.draw);
    }
  } else if (instruction.operation == Operation::Call) {
    const ColumnValue c = instruction.count > 2 ? operand(instruction.operands[2]) : ColumnValue{};
    std::array<double, 3> arguments{};
    for (std::size_t i = 0; i < count; ++i) {
      arguments = {at(a, i), at(b, i), at(c, i)};
      target[i] = language::callPure(static_cast<Function>(instruction.function), {arguments.data(), instruction.count},
                                     dividesByZero);
    }
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      target[i] = language::applyBinary(instruction.operation, at(a, i), at(b, i), dividesByZero);
    }
  }
  if (dividesByZero) {
    noteDivision(instruction.instruction);
  }
}

void ColumnEvaluator::runPerLane(const ColumnExpression& expression, double* target) {
  for (const std::uint32_t index : expression.slots) {
    static_cast<void>(slot(index));
  }
  for (std::size_t i = 0; i < lanes_.count; ++i) {
    for (const std::uint32_t index : expression.slots) {
      frame_[index] = slots_[index * kLanes + i];
    }
    target[i] = runLane(expression.expression->code);
  }
}

double ColumnEvaluator::runLane(language::CodeRange code) {
  double* top = stack_.data();
  for (std::uint32_t place = code.begin; place < code.end;) {
    const Instruction& instruction = program_->code[place];
    std::uint32_t next = place + 1;
    bool dividedByZero = false;
    switch (instruction.operation) {
      case Operation::Constant:
        *top++ = program_->constants[instruction.operand];
        break;
      case Operation::LoadSlot:
        *top++ = frame_[instruction.operand];
        break;
      case Operation::LoadStep:
        *top++ = step_;
        break;
      case Operation::LoadLength:
        *top++ = length_;
        break;
      case Operation::Pop:
        --top;
        break;
      case Operation::Negate:
      case Operation::Not:
      case Operation::ToBoolean:
        top[-1] = language::applyUnary(instruction.operation, top[-1]);
        break;
      case Operation::Select:
        top -= 2;
        top[-1] = language::isTrue(top[-1]) ? top[0] : top[1];
        break;
      case Operation::Jump:
        next = instruction.operand;
        break;
      case Operation::JumpIfZero:
        next = language::isTrue(*--top) ? next : instruction.operand;
        break;
      case Operation::JumpIfNonZero:
        next = language::isTrue(*--top) ? instruction.operand : next;
        break;
      case Operation::JumpIfOrSkips:
        next = language::orSkips(top[-1]) ? instruction.operand : next;
        break;
      case Operation::Call:
        top -= instruction.count;
        *top = language::callPure(static_cast<Function>(instruction.operand), {top, instruction.count}, dividedByZero);
        ++top;
        break;
      default:
        --top;
        top[-1] = language::applyBinary(instruction.operation, top[-1], top[0], dividedByZero);
        break;
    }
    if (dividedByZero) {
      noteDivision(place);
    }
    place = next;
  }
  return stack_[0];
}

}  // namespace espalier::derivation

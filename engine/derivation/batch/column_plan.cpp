#include "engine/derivation/batch/column_plan.h"

#include <algorithm>

#include "engine/language/arithmetic.h"

namespace espalier::derivation {
namespace {

using language::Expression;
using language::Function;
using language::Instruction;
using language::Operation;

bool isJump(Operation operation) {
  return operation == Operation::Jump || operation == Operation::JumpIfZero || operation == Operation::JumpIfNonZero ||
         operation == Operation::JumpIfOrSkips;
}

/// The number of operands that an instruction takes from the stack. Every instruction but Pop leaves one value.
std::uint16_t operandCount(const Instruction& instruction) {
  switch (instruction.operation) {
    case Operation::Negate:
    case Operation::Not:
    case Operation::ToBoolean:
      return 1;
    case Operation::Select:
      return 3;
    case Operation::Call:
      return instruction.count;
    default:
      return 2;
  }
}

bool isRan(const Instruction& instruction) {
  return instruction.operation == Operation::Call && static_cast<Function>(instruction.operand) == Function::Ran;
}

bool isColumnInstruction(const Instruction& instruction) {
  switch (instruction.operation) {
    case Operation::Constant:
    case Operation::LoadSlot:
    case Operation::LoadStep:
    case Operation::LoadLength:
    case Operation::Pop:
    case Operation::Negate:
    case Operation::Not:
    case Operation::ToBoolean:
    case Operation::Select:
      return true;
    case Operation::Call:
      return language::isArithmetic(static_cast<Function>(instruction.operand)) && instruction.count >= 1 &&
             instruction.count <= 3;
    default:
      return isJump(instruction.operation) ||
             (instruction.operation >= Operation::Add && instruction.operation <= Operation::LogicalOr);
  }
}

}  // namespace

bool isColumnExpression(const language::Program& program, const Expression& expression) {
  if (expression.kind != Expression::Kind::Code) {
    return true;
  }
  if (!expression.isPure) {
    return false;
  }
  for (std::uint32_t at = expression.code.begin; at < expression.code.end; ++at) {
    const Instruction& instruction = program.code[at];
    // a jump back is a loop, and the Evaluator counts its turns
    if (!isColumnInstruction(instruction) || (isJump(instruction.operation) && instruction.operand <= at)) {
      return false;
    }
  }
  return true;
}

bool isDrawingColumnExpression(const language::Program& program, const Expression& expression) {
  if (isColumnExpression(program, expression)) {
    return true;
  }
  if (program.compatibility != core::Compatibility::Espalier) {
    return false;
  }
  for (std::uint32_t at = expression.code.begin; at < expression.code.end; ++at) {
    const Instruction& instruction = program.code[at];
    // behind a jump the number of draws depends on the parameters
    if (isJump(instruction.operation) || !(isColumnInstruction(instruction) || isRan(instruction))) {
      return false;
    }
  }
  return true;
}

ColumnExpression makeColumnExpression(const language::Program& program, const Expression& expression,
                                      std::uint32_t firstDraw) {
  ColumnExpression result;
  result.expression = &expression;
  const auto reads = [&result](std::uint32_t slot) {
    if (std::find(result.slots.begin(), result.slots.end(), slot) == result.slots.end()) {
      result.slots.push_back(slot);
    }
  };
  if (expression.kind == Expression::Kind::Constant) {
    result.result.constant = expression.constant;
    return result;
  }
  if (expression.kind == Expression::Kind::Slot) {
    result.result = {ColumnOperand::Kind::Slot, expression.slot, 0.0};
    reads(expression.slot);
    return result;
  }

  // the stack before each instruction; the height of an intermediate result is its number
  std::vector<ColumnOperand> stack;
  for (std::uint32_t at = expression.code.begin; at < expression.code.end; ++at) {
    const Instruction& instruction = program.code[at];
    result.isPerLane = result.isPerLane || isJump(instruction.operation);
    switch (instruction.operation) {
      case Operation::Constant:
        stack.push_back({ColumnOperand::Kind::Constant, 0, program.constants[instruction.operand]});
        break;
      case Operation::LoadSlot:
        stack.push_back({ColumnOperand::Kind::Slot, instruction.operand, 0.0});
        reads(instruction.operand);
        break;
      case Operation::LoadStep:
        stack.push_back({ColumnOperand::Kind::Step, 0, 0.0});
        break;
      case Operation::LoadLength:
        stack.push_back({ColumnOperand::Kind::Length, 0, 0.0});
        break;
      default: {
        // with jumps the order of the code does not give the heights; only the slots are needed
        if (result.isPerLane) {
          break;
        }
        if (instruction.operation == Operation::Pop) {
          stack.pop_back();
          break;
        }
        ColumnInstruction made;
        made.operation = instruction.operation;
        made.function = instruction.operand;
        made.count = operandCount(instruction);
        made.instruction = at;
        if (isRan(instruction)) {
          made.draw = firstDraw + result.drawCount;
          ++result.drawCount;
        }
        std::copy(stack.end() - made.count, stack.end(), made.operands.begin());
        stack.resize(stack.size() - made.count);
        made.target = static_cast<std::uint32_t>(stack.size());
        stack.push_back({ColumnOperand::Kind::Column, made.target, 0.0});
        result.instructions.push_back(made);
      }
    }
  }
  if (result.isPerLane) {
    result.instructions.clear();
  } else {
    result.result = stack.back();
  }
  return result;
}

}  // namespace espalier::derivation

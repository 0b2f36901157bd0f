#include "clients/espalier/sweep/start_values.h"

#include <algorithm>
#include <cstdint>

namespace espalier::command {
namespace {

using language::CodeRange;
using language::Instruction;
using language::Operation;

bool isJump(Operation operation) {
  return operation == Operation::Jump || operation == Operation::JumpIfZero || operation == Operation::JumpIfNonZero ||
         operation == Operation::JumpIfOrSkips;
}

}  // namespace

StartValues::StartValues(const language::Program& program, const std::vector<std::size_t>& variables)
    : program_(std::make_shared<language::Program>(program)), firstConstant_(program.constants.size()) {
  language::Program& own = *program_;
  language::LSystem& system = own.systems.front();
  own.constants.resize(firstConstant_ + variables.size());
  const CodeRange start = system.start;
  const auto begin = static_cast<std::uint32_t>(own.code.size());
  const auto add = [&own](Instruction instruction, core::SourceRange range) {
    own.code.push_back(instruction);
    own.codeRanges.push_back(range);
  };
  // first the values, so that Start can compute with them
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const auto constant = static_cast<std::uint32_t>(firstConstant_ + i);
    add({.operation = Operation::Constant, .count = 0, .operand = constant}, {});
    add({.operation = Operation::StoreVariable, .count = 0, .operand = static_cast<std::uint32_t>(variables[i])}, {});
  }
  // then Start, which drops what it assigns to these variables
  const auto moved = static_cast<std::uint32_t>(own.code.size()) - start.begin;
  for (std::uint32_t at = start.begin; at < start.end; ++at) {
    Instruction instruction = own.code[at];
    if (isJump(instruction.operation)) {
      instruction.operand += moved;
    } else if (instruction.operation == Operation::StoreVariable &&
               std::find(variables.begin(), variables.end(), instruction.operand) != variables.end()) {
      instruction.operation = Operation::Pop;
    }
    add(instruction, own.codeRanges[at]);
  }
  system.start = {.begin = begin, .end = static_cast<std::uint32_t>(own.code.size())};
  own.maximumStack = std::max(own.maximumStack, std::uint32_t{1});
}

void StartValues::set(std::span<const double> values) {
  std::copy(values.begin(), values.end(), program_->constants.begin() + static_cast<std::ptrdiff_t>(firstConstant_));
}

}  // namespace espalier::command

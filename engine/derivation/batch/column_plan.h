#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/language/program.h"

namespace espalier::derivation {

/// The operand of an operation on columns.
struct ColumnOperand {
  enum class Kind : std::uint8_t {
    Constant,
    Slot,    // formal parameter `index` of each lane
    Column,  // intermediate result `index`
    Step,    // Q
    Length,  // Z
  };
  Kind kind = Kind::Constant;
  std::uint32_t index = 0;
  double constant = 0.0;
};

/// One operation of an expression. A batch does it for all lanes before the next operation.
struct ColumnInstruction {
  language::Operation operation = language::Operation::Add;
  std::uint32_t function = 0;     // Call: a language::Function
  std::uint16_t count = 0;        // operands
  std::uint32_t target = 0;       // intermediate result that is made
  std::uint32_t instruction = 0;  // in Program::code, for warnings
  std::uint32_t draw = 0;         // ran: number of the draw in its module
  std::array<ColumnOperand, 3> operands;
};

/// An expression in the form that a batch evaluates. Numbered columns take the place of the stack.
struct ColumnExpression {
  const language::Expression* expression = nullptr;  // in the Program
  bool isPerLane = false;                            // it jumps: each lane runs the code on its own
  std::vector<ColumnInstruction> instructions;
  ColumnOperand result;
  std::vector<std::uint32_t> slots;  // formal parameters that are read, each once
  std::uint32_t drawCount = 0;       // calls of ran
};

/// Whether a batch can evaluate the expression: it depends only on formal parameters, constants, Q and Z, and calls
/// only arithmetic functions.
[[nodiscard]] bool isColumnExpression(const language::Program& program, const language::Expression& expression);

/// The same for the parameters of a successor. They may also call ran where every evaluation reaches the call.
/// Espalier's own mode names a draw by its module and its number, so the order of rewriting does not matter.
[[nodiscard]] bool isDrawingColumnExpression(const language::Program& program, const language::Expression& expression);

/// The form for a batch of an expression for which one of the two functions above is true. Its first call of ran makes
/// draw number `firstDraw` of the module.
[[nodiscard]] ColumnExpression makeColumnExpression(const language::Program& program,
                                                    const language::Expression& expression,
                                                    std::uint32_t firstDraw = 0);

}  // namespace espalier::derivation

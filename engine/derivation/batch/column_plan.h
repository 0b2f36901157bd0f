#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/language/program.h"

namespace espalier::derivation {

/// The operand of an operation on columns.
struct ColumnOperand {
  enum class Kind : std::uint8_t {
    Constant,
    Slot,      // formal parameter `index` of each lane, as the module or its neighbour has it
    Column,    // local variable, formal parameter that a block has assigned, or intermediate result `index`
    Variable,  // variable `index` of the L-system: the same for all lanes, because no batch assigns it
    Step,      // Q
    Length,    // Z
  };
  Kind kind = Kind::Constant;
  std::uint32_t index = 0;
  double constant = 0.0;
};

/// One operation of an expression or a block. A batch does it for all lanes before the next operation.
struct ColumnInstruction {
  /// The operation of the Program. StoreStatic copies operand 0 to the target, in the lanes that reach it.
  language::Operation operation = language::Operation::Add;
  std::uint32_t function = 0;     // Call: a language::Function; LoadElement: the array
  std::uint16_t count = 0;        // operands
  bool isStore = false;           // StoreStatic behind or before a jump, to a local variable
  std::uint32_t target = 0;       // column that is made
  std::uint32_t instruction = 0;  // in Program::code, for warnings
  std::array<ColumnOperand, 4> operands;
};

/// Instructions without a jump, and the jump behind them.
struct ColumnStretch {
  std::uint32_t end = 0;  // in ColumnCode::instructions; the stretch begins where the one before ends
  /// Jump, JumpIfZero, JumpIfNonZero or JumpIfOrSkips to the stretch `target`; Pop: no jump.
  language::Operation jump = language::Operation::Pop;
  ColumnOperand test;
  std::uint32_t target = 0;  // the number of stretches: the end of the code
};

/// The code of an expression or a block in the form that a batch runs. Numbered columns take the place of the stack and
/// of what blocks assign. The first columns hold the local variables, the next the formal parameters that a block
/// assigns (ColumnCompiler::columnCount).
struct ColumnCode {
  std::vector<ColumnInstruction> instructions;
  std::vector<ColumnStretch> stretches;  // empty: the code has no jump
  ColumnOperand result;                  // of an expression
  std::uint32_t columnCount = 0;         // columns that the code uses, with all that hold what blocks assign
  bool drawsRandom = false;              // it calls ran, nran or bran
  std::vector<std::uint32_t> stores;     // local variables that a run may assign, each once
};

/// Translates the code of one production, piece by piece in the order in which the pieces run: pre-block, condition,
/// weight, post-block, successor. The pieces share the local variables of the production (Program::staticNames). They
/// must assign a local variable before they read it; otherwise its value would come from the module before.
class ColumnCompiler {
 public:
  /// `program` must outlive the object. Pre-block and post-block of `production` name the local variables.
  ColumnCompiler(const language::Program& program, const language::Production& production);

  /// The static of each local variable.
  [[nodiscard]] const std::vector<std::uint32_t>& locals() const { return locals_; }
  /// The columns that hold what blocks assign: the local variables, then formal parameters. Those that no block has
  /// assigned yet are read where the module has them.
  [[nodiscard]] std::size_t columnCount() const { return locals_.size() + formals_.size(); }
  /// By column: whether the pieces so far have assigned it for certain.
  [[nodiscard]] const std::vector<bool>& assigned() const { return assigned_; }

  /// The form for a batch; nothing when a batch cannot run the code, for the reason in problem(). Code may read formal
  /// parameters, constants, Q, Z, variables, arrays and functions of the view file. It may assign local variables and
  /// formal parameters. With `mayDraw` it may call ran, nran and bran: Espalier's own mode names a draw by its module
  /// and its number in the module, so the order of rewriting does not matter.
  [[nodiscard]] std::optional<ColumnCode> block(language::CodeRange code, bool mayDraw);
  [[nodiscard]] std::optional<ColumnCode> expression(const language::Expression& expression, bool mayDraw);

  /// The reason of the last failure, as the end of a sentence.
  [[nodiscard]] const char* problem() const { return problem_; }

 private:
  class Translation;

  [[nodiscard]] std::optional<ColumnCode> translate(language::CodeRange code, bool mayDraw);
  /// columnCount() where there is none.
  [[nodiscard]] std::uint32_t columnOfLocal(std::uint32_t variable) const;
  [[nodiscard]] std::uint32_t columnOfFormal(std::uint32_t slot) const;
  [[nodiscard]] ColumnOperand formal(std::uint32_t slot, const std::vector<bool>& assigned) const;

  const language::Program* program_;
  std::vector<std::uint32_t> locals_;
  std::vector<std::uint32_t> formals_;  // numbers of formal parameters that a block assigns
  std::vector<bool> assigned_;          // by column
  const char* problem_ = "";
};

}  // namespace espalier::derivation

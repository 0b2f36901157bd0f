#include "engine/derivation/batch/column_plan.h"

#include <algorithm>
#include <utility>

#include "engine/derivation/expressions/view_functions.h"
#include "engine/language/arithmetic.h"

namespace espalier::derivation {
namespace {

using language::CodeRange;
using language::Expression;
using language::Function;
using language::Instruction;
using language::Operation;

// code with more jumps than this is left to the Evaluator
constexpr std::size_t kMostStretches = 128;

bool isJump(Operation operation) {
  return operation == Operation::Jump || operation == Operation::JumpIfZero || operation == Operation::JumpIfNonZero ||
         operation == Operation::JumpIfOrSkips;
}

/// Whether it draws, and never fails. biran has a limit.
bool isDraw(const Instruction& instruction) {
  const auto function = static_cast<Function>(instruction.operand);
  return instruction.operation == Operation::Call &&
         (function == Function::Ran || function == Function::Nran || function == Function::Bran);
}

/// Whether every call gives the same for the same arguments, and a column can hold the result.
bool isPureCall(const Instruction& instruction) {
  const auto function = static_cast<Function>(instruction.operand);
  return language::isArithmetic(function) || isViewFunction(function);
}

/// The number of operands that an operation takes from the stack.
std::uint16_t operandCount(const Instruction& instruction) {
  switch (instruction.operation) {
    case Operation::Negate:
    case Operation::Not:
    case Operation::ToBoolean:
      return 1;
    case Operation::Select:
      return 3;
    case Operation::Call:
    case Operation::LoadElement:
      return instruction.count;
    default:
      return 2;
  }
}

}  // namespace

/// One pass over the code. It follows the stack and the assigned columns. Values that are on the stack where stretches
/// meet are carried in columns of their own, numbered by their height.
class ColumnCompiler::Translation {
 public:
  Translation(ColumnCompiler& compiler, CodeRange code, bool mayDraw)
      : compiler_(compiler),
        program_(*compiler.program_),
        code_(code),
        mayDraw_(mayDraw),
        namedCount_(static_cast<std::uint32_t>(compiler.columnCount())),
        isStart_(code.end - code.begin + std::size_t{1}, false) {}

  [[nodiscard]] bool run();
  [[nodiscard]] ColumnCode take() { return std::move(made_); }

 private:
  /// The state that is known where a stretch begins.
  struct Entry {
    bool isReached = false;
    std::size_t height = 0;
    std::vector<bool> assigned;
  };

  bool fail(const char* problem) {
    compiler_.problem_ = problem;
    return false;
  }
  [[nodiscard]] bool hasJumps() const { return entries_.size() > 2; }
  [[nodiscard]] std::uint32_t carrier(std::size_t height) const {
    return namedCount_ + static_cast<std::uint32_t>(height);
  }
  /// One of two columns for each height: an operation does not write to the column of its first operand, because loops
  /// over columns that may overlap use no vector instructions.
  [[nodiscard]] std::uint32_t temporary(std::size_t height, const ColumnOperand& first) const {
    const std::uint32_t column =
        namedCount_ + (hasJumps() ? program_.maximumStack : 0U) + 2 * static_cast<std::uint32_t>(height);
    return first.kind == ColumnOperand::Kind::Column && first.index == column ? column + 1 : column;
  }
  void findStarts();
  void copyFormals();
  void openStretch();
  bool closeStretch(const Instruction* jump);
  bool enter(std::size_t stretch);
  bool translate(std::uint32_t at);
  bool load(const Instruction& instruction);
  bool store(std::uint32_t column);
  bool operate(const Instruction& instruction, std::uint32_t at);
  void emit(const ColumnInstruction& instruction);
  void emitMove(const ColumnOperand& from, std::uint32_t target);

  ColumnCompiler& compiler_;
  const language::Program& program_;
  CodeRange code_;
  bool mayDraw_;
  std::uint32_t namedCount_;              // columns of local variables and formal parameters
  std::vector<bool> isStart_;             // by place in the code: a stretch begins here
  std::vector<std::uint32_t> stretchAt_;  // the same: the stretch that begins here, or the next
  std::vector<Entry> entries_;            // by stretch, and of the end
  std::vector<std::uint32_t> copied_;     // columns that begin with the value of their formal parameter
  bool isClosed_ = true;                  // no stretch is open
  bool isReachable_ = true;               // the open stretch
  std::vector<ColumnOperand> stack_;
  std::vector<bool> assigned_;
  ColumnCode made_;
};

void ColumnCompiler::Translation::findStarts() {
  isStart_.front() = true;
  isStart_.back() = true;
  bool jumps = false;
  for (std::uint32_t at = code_.begin; at < code_.end; ++at) {
    const Instruction& instruction = program_.code[at];
    if (isJump(instruction.operation)) {
      jumps = true;
      isStart_[at + 1 - code_.begin] = true;
      isStart_[instruction.operand - code_.begin] = true;
    } else if (instruction.operation == Operation::StoreSlot) {
      const std::uint32_t column = compiler_.columnOfFormal(instruction.operand);
      if (!compiler_.assigned_[column] && std::find(copied_.begin(), copied_.end(), column) == copied_.end()) {
        copied_.push_back(column);
      }
    }
  }
  // without jumps it is known at every place whether the parameter has been assigned
  if (!jumps) {
    copied_.clear();
  }
  if (!copied_.empty()) {
    entries_.emplace_back();
  }
  for (const bool isStart : isStart_) {
    stretchAt_.push_back(static_cast<std::uint32_t>(entries_.size()));
    if (isStart) {
      entries_.emplace_back();
    }
  }
}

bool ColumnCompiler::Translation::run() {
  findStarts();
  if (entries_.size() > kMostStretches) {
    return fail("its code has too many jumps");
  }
  entries_.front() = {true, 0, compiler_.assigned_};
  if (!copied_.empty()) {
    copyFormals();
  }
  for (std::uint32_t at = code_.begin; at < code_.end; ++at) {
    if (isStart_[at - code_.begin]) {
      if (!isClosed_ && !closeStretch(nullptr)) {
        return false;
      }
      openStretch();
    }
    const Instruction& instruction = program_.code[at];
    if (!(isJump(instruction.operation) ? closeStretch(&instruction) : !isReachable_ || translate(at))) {
      return false;
    }
  }
  if (!isClosed_ && !closeStretch(nullptr)) {
    return false;
  }
  const Entry& end = entries_.back();
  if (!end.isReached) {
    return fail("a loop does not end");
  }
  compiler_.assigned_ = end.assigned;
  if (end.height > 0) {
    made_.result = hasJumps() ? ColumnOperand{ColumnOperand::Kind::Column, carrier(0), 0.0} : stack_.front();
  }
  made_.columnCount = std::max(made_.columnCount, namedCount_);
  if (!hasJumps()) {
    made_.stretches.clear();
  }
  return true;
}

/// The first stretch: lanes that jump over an assignment to a formal parameter find its value in the same column.
void ColumnCompiler::Translation::copyFormals() {
  Entry next = entries_.front();
  for (const std::uint32_t column : copied_) {
    const std::uint32_t formal = compiler_.formals_[column - compiler_.locals_.size()];
    emitMove({ColumnOperand::Kind::Slot, formal, 0.0}, column);
    next.assigned[column] = true;
  }
  ColumnStretch copies;
  copies.end = static_cast<std::uint32_t>(made_.instructions.size());
  made_.stretches.push_back(copies);
  entries_[1] = std::move(next);
}

void ColumnCompiler::Translation::openStretch() {
  isClosed_ = false;
  const Entry& entry = entries_[made_.stretches.size()];
  isReachable_ = entry.isReached;
  assigned_ = entry.assigned;
  stack_.clear();
  for (std::size_t height = 0; height < entry.height; ++height) {
    stack_.push_back({ColumnOperand::Kind::Column, carrier(height), 0.0});
  }
}

bool ColumnCompiler::Translation::closeStretch(const Instruction* jump) {
  isClosed_ = true;
  const std::size_t number = made_.stretches.size();
  ColumnStretch stretch;
  if (isReachable_ && jump != nullptr) {
    stretch.jump = jump->operation;
    stretch.target = stretchAt_[jump->operand - code_.begin];
    if (jump->operation != Operation::Jump) {
      stretch.test = stack_.back();
      if (jump->operation != Operation::JumpIfOrSkips) {
        stack_.pop_back();
      }
    }
  }
  // values that stay on the stack move to the columns in which the next stretches expect them
  for (std::size_t height = 0; hasJumps() && isReachable_ && height < stack_.size(); ++height) {
    const ColumnOperand operand = stack_[height];
    if (operand.kind != ColumnOperand::Kind::Column || operand.index != carrier(height)) {
      emitMove(operand, carrier(height));
    }
  }
  stretch.end = static_cast<std::uint32_t>(made_.instructions.size());
  made_.stretches.push_back(stretch);
  if (!isReachable_) {
    return true;
  }
  // at the beginning of a loop, what is known there holds behind the jump back too
  const bool jumpsForward = stretch.jump != Operation::Pop && stretch.target > number;
  return (!jumpsForward || enter(stretch.target)) && (stretch.jump == Operation::Jump || enter(number + 1));
}

bool ColumnCompiler::Translation::enter(std::size_t stretch) {
  Entry& entry = entries_[stretch];
  if (!entry.isReached) {
    entry = {true, stack_.size(), assigned_};
    return true;
  }
  if (entry.height != stack_.size()) {
    return fail("its code is not understood");
  }
  for (std::size_t i = 0; i < assigned_.size(); ++i) {
    entry.assigned[i] = entry.assigned[i] && assigned_[i];
  }
  return true;
}

bool ColumnCompiler::Translation::translate(std::uint32_t at) {
  const Instruction& instruction = program_.code[at];
  switch (instruction.operation) {
    case Operation::Constant:
    case Operation::LoadSlot:
    case Operation::LoadStatic:
    case Operation::LoadVariable:
    case Operation::LoadStep:
    case Operation::LoadLength:
      return load(instruction);
    case Operation::StoreStatic:
      return store(compiler_.columnOfLocal(instruction.operand));
    case Operation::StoreSlot:
      return store(compiler_.columnOfFormal(instruction.operand));
    case Operation::StoreVariable:
    case Operation::StoreElement:
      return fail("a block assigns a variable of the L-system");
    case Operation::Pop:
      stack_.pop_back();
      return true;
    case Operation::Call:
      return isPureCall(instruction) || (isDraw(instruction) && mayDraw_)
                 ? operate(instruction, at)
                 : fail("it calls a function that draws or has an effect");
    case Operation::LoadElement:
      return instruction.count <= 4 ? operate(instruction, at) : fail("an array has more than four subscripts");
    case Operation::Print:
    case Operation::FileOpen:
    case Operation::FileClose:
    case Operation::FileFlush:
    case Operation::FilePrint:
    case Operation::FileScan:
      return fail("it prints, or uses files");
    default:
      return operate(instruction, at);
  }
}

bool ColumnCompiler::Translation::load(const Instruction& instruction) {
  const std::uint32_t index = instruction.operand;
  switch (instruction.operation) {
    case Operation::Constant:
      stack_.push_back({ColumnOperand::Kind::Constant, 0, program_.constants[index]});
      return true;
    case Operation::LoadSlot:
      stack_.push_back(compiler_.formal(index, assigned_));
      return true;
    case Operation::LoadVariable:
      stack_.push_back({ColumnOperand::Kind::Variable, index, 0.0});
      return true;
    case Operation::LoadStep:
      stack_.push_back({ColumnOperand::Kind::Step, 0, 0.0});
      return true;
    case Operation::LoadLength:
      stack_.push_back({ColumnOperand::Kind::Length, 0, 0.0});
      return true;
    default:
      break;
  }
  const std::uint32_t local = compiler_.columnOfLocal(index);
  if (local == namedCount_ || !assigned_[local]) {
    return fail("it reads a local variable that the module before may have left");
  }
  stack_.push_back({ColumnOperand::Kind::Column, local, 0.0});
  return true;
}

bool ColumnCompiler::Translation::store(std::uint32_t column) {
  if (column == namedCount_ || stack_.size() != 1) {
    return fail("its code is not understood");
  }
  const ColumnOperand value = stack_.back();
  stack_.pop_back();
  assigned_[column] = true;
  const bool isLocal = column < compiler_.locals_.size();
  if (isLocal && std::find(made_.stores.begin(), made_.stores.end(), column) == made_.stores.end()) {
    made_.stores.push_back(column);
  }
  // the last operation writes to the variable itself
  if (!hasJumps() && value.kind == ColumnOperand::Kind::Column && value.index >= namedCount_) {
    made_.instructions.back().target = column;
    return true;
  }
  emitMove(value, column);
  made_.instructions.back().isStore = isLocal && hasJumps();
  return true;
}

bool ColumnCompiler::Translation::operate(const Instruction& instruction, std::uint32_t at) {
  ColumnInstruction made;
  made.operation = instruction.operation;
  made.function = instruction.operand;
  made.count = operandCount(instruction);
  made.instruction = at;
  if (made.count > made.operands.size() || made.count > stack_.size()) {
    return fail("a function has too many arguments");
  }
  made_.drawsRandom = made_.drawsRandom || isDraw(instruction);
  std::copy(stack_.end() - made.count, stack_.end(), made.operands.begin());
  stack_.resize(stack_.size() - made.count);
  made.target = temporary(stack_.size(), made.operands[0]);
  stack_.push_back({ColumnOperand::Kind::Column, made.target, 0.0});
  emit(made);
  return true;
}

void ColumnCompiler::Translation::emitMove(const ColumnOperand& from, std::uint32_t target) {
  ColumnInstruction move;
  move.operation = Operation::StoreStatic;
  move.count = 1;
  move.target = target;
  move.operands[0] = from;
  emit(move);
}

void ColumnCompiler::Translation::emit(const ColumnInstruction& instruction) {
  made_.columnCount = std::max(made_.columnCount, instruction.target + 1);
  made_.instructions.push_back(instruction);
}

ColumnCompiler::ColumnCompiler(const language::Program& program, const language::Production& production)
    : program_(&program) {
  const auto add = [](std::vector<std::uint32_t>& names, std::uint32_t name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      names.push_back(name);
    }
  };
  for (const CodeRange code : {production.preBlock, production.postBlock}) {
    for (std::uint32_t at = code.begin; at < code.end; ++at) {
      const Instruction& instruction = program.code[at];
      if (instruction.operation == Operation::StoreStatic) {
        add(locals_, instruction.operand);
      } else if (instruction.operation == Operation::StoreSlot) {
        add(formals_, instruction.operand);
      }
    }
  }
  assigned_.resize(columnCount(), false);
}

std::uint32_t ColumnCompiler::columnOfLocal(std::uint32_t variable) const {
  const auto found = std::find(locals_.begin(), locals_.end(), variable);
  const auto place = static_cast<std::size_t>(found - locals_.begin());
  return static_cast<std::uint32_t>(place == locals_.size() ? columnCount() : place);
}

std::uint32_t ColumnCompiler::columnOfFormal(std::uint32_t slot) const {
  const auto found = std::find(formals_.begin(), formals_.end(), slot);
  return static_cast<std::uint32_t>(locals_.size() + static_cast<std::size_t>(found - formals_.begin()));
}

ColumnOperand ColumnCompiler::formal(std::uint32_t slot, const std::vector<bool>& assigned) const {
  const std::uint32_t column = columnOfFormal(slot);
  return column < columnCount() && assigned[column] ? ColumnOperand{ColumnOperand::Kind::Column, column, 0.0}
                                                    : ColumnOperand{ColumnOperand::Kind::Slot, slot, 0.0};
}

std::optional<ColumnCode> ColumnCompiler::translate(CodeRange code, bool mayDraw) {
  Translation translation(*this, code, mayDraw);
  if (!translation.run()) {
    return std::nullopt;
  }
  return translation.take();
}

std::optional<ColumnCode> ColumnCompiler::block(CodeRange code, bool mayDraw) {
  return code.empty() ? ColumnCode{} : translate(code, mayDraw);
}

std::optional<ColumnCode> ColumnCompiler::expression(const Expression& expression, bool mayDraw) {
  ColumnCode made;
  switch (expression.kind) {
    case Expression::Kind::Constant:
      made.result.constant = expression.constant;
      return made;
    case Expression::Kind::Slot:
      made.result = formal(expression.slot, assigned_);
      return made;
    case Expression::Kind::Code:
      break;
  }
  return translate(expression.code, mayDraw);
}

}  // namespace espalier::derivation

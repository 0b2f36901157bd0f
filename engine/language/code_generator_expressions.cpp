#include <algorithm>
#include <bit>
#include <utility>

#include "engine/core/check.h"
#include "engine/core/work_meter.h"
#include "engine/files/file_name.h"
#include "engine/language/arithmetic.h"
#include "engine/language/code_generator.h"
#include "engine/language/constant_evaluation.h"

namespace espalier::language {

// ---- what expressions depend on

void CodeGenerator::computeTraits() {
  // children come before their parents
  traits_.reserve(model_.expressions.size());
  for (const ExpressionNode& node : model_.expressions) {
    traits_.push_back(traitsOf(node));
  }
}

CodeGenerator::Traits CodeGenerator::traitsOf(const ExpressionNode& node) const {
  Traits traits;
  for (const ExpressionIndex child : node.children) {
    const Traits& other = traits_[child];
    traits.isPure = traits.isPure && other.isPure;
    traits.drawsRandom = traits.drawsRandom || other.drawsRandom;
    traits.isOtherwisePure = traits.isOtherwisePure && other.isOtherwisePure;
    traits.isSimple = traits.isSimple && other.isSimple;
  }
  bool isOther = false;
  switch (node.kind) {
    case ExpressionKind::Name:
      isOther = node.binding.kind == Binding::Kind::Variable || node.binding.kind == Binding::Kind::Static;
      break;
    case ExpressionKind::Element:
    case ExpressionKind::Reference:
      isOther = true;
      traits.isSimple = false;
      break;
    case ExpressionKind::Binary:
      traits.isSimple = traits.isSimple && node.operation != Operation::Divide && node.operation != Operation::Modulo;
      break;
    case ExpressionKind::Call: {
      const bool isFunction = node.callee == Callee::Function;
      const bool draws = isFunction && drawsRandom(node.function);
      traits.drawsRandom = traits.drawsRandom || draws;
      traits.isPure = traits.isPure && !draws;
      isOther = !isFunction || (!draws && !functionInfo(node.function).isPure);
      traits.isSimple = false;
      break;
    }
    default:
      break;
  }
  constexpr std::uint32_t kSimpleDepth = 3;
  traits.isSimple = traits.isSimple && node.depth <= kSimpleDepth;
  traits.isPure = traits.isPure && !isOther;
  traits.isOtherwisePure = traits.isOtherwisePure && !isOther;
  return traits;
}

// ---- tables

std::uint32_t CodeGenerator::internConstant(double value) {
  const auto [place, isNew] = constantIndex_.emplace(std::bit_cast<std::uint64_t>(value),
                                                     static_cast<std::uint32_t>(program_.constants.size()));
  if (isNew) {
    program_.constants.push_back(value);
  }
  return place->second;
}

std::uint32_t CodeGenerator::internString(const std::string& text) {
  const auto [place, isNew] = stringIndex_.emplace(text, static_cast<std::uint32_t>(program_.strings.size()));
  if (isNew) {
    program_.strings.push_back(text);
  }
  return place->second;
}

std::uint32_t CodeGenerator::internFile(const std::string& name, const FileMode& mode) {
  const bool isInside = files::isNameInside(name);
  const std::string plain = isInside ? files::withoutDots(name) : name;
  const auto found = std::find_if(program_.files.begin(), program_.files.end(),
                                  [&](const ModelFile& file) { return file.name == plain; });
  const auto index = static_cast<std::uint32_t>(found - program_.files.begin());
  if (found == program_.files.end()) {
    program_.files.push_back({.name = plain, .isRefused = !isInside});
  }
  ModelFile& file = program_.files[index];
  file.isRead = file.isRead || mode.canRead;
  file.isWritten = file.isWritten || mode.canWrite;
  return index;
}

std::uint32_t CodeGenerator::addStatic(std::string name) {
  program_.staticNames.push_back(std::move(name));
  return static_cast<std::uint32_t>(program_.staticNames.size() - 1);
}

std::uint32_t CodeGenerator::emit(Operation operation, std::uint32_t operand, std::size_t count,
                                  core::SourceRange range, int stackChange) {
  stackDepth_ += stackChange;
  ESPALIER_CHECK(stackDepth_ >= 0 && count <= 0xFFFFU);
  program_.maximumStack = std::max(program_.maximumStack, static_cast<std::uint32_t>(stackDepth_));
  program_.code.push_back({operation, static_cast<std::uint16_t>(count), operand});
  program_.codeRanges.push_back(range);
  return here() - 1;
}

void CodeGenerator::patch(std::uint32_t instruction) {
  program_.code[instruction].operand = here();
}

void CodeGenerator::emitConstant(double value, core::SourceRange range) {
  emit(Operation::Constant, internConstant(value), 0, range, 1);
}

// ---- whole expressions and blocks

Expression CodeGenerator::generateExpression(ExpressionIndex index) {
  const ExpressionNode& node = at(index);
  Expression expression;
  expression.range = node.range;
  expression.isPure = traits_[index].isPure;
  if (values_[index].has_value()) {
    expression.constant = *values_[index];
  } else if (node.kind == ExpressionKind::String) {
    // the text of a label: its number in Program::strings
    expression.constant = static_cast<double>(internString(node.text));
  } else if (node.kind == ExpressionKind::Name && node.binding.kind == Binding::Kind::Slot) {
    expression.kind = Expression::Kind::Slot;
    expression.slot = node.binding.index;
  } else {
    expression.kind = Expression::Kind::Code;
    expression.code.begin = here();
    stackDepth_ = 0;
    emitExpression(index);
    expression.code.end = here();
    ESPALIER_CHECK(stackDepth_ == 1);
  }
  return expression;
}

CodeRange CodeGenerator::generateBlock(const Block& block) {
  CodeRange range{here(), here()};
  stackDepth_ = 0;
  emitStatements(block.statements);
  range.end = here();
  ESPALIER_CHECK(stackDepth_ == 0);
  return range;
}

void CodeGenerator::emitStatements(const std::vector<Statement>& statements) {
  for (const Statement& statement : statements) {
    emitStatement(statement);
  }
}

void CodeGenerator::emitStatement(const Statement& statement) {
  switch (statement.kind) {
    case Statement::Kind::Assign: {
      const ExpressionNode& target = at(statement.target);
      if (target.kind == ExpressionKind::Element) {
        std::for_each(target.children.begin(), target.children.end(), [&](ExpressionIndex i) { emitExpression(i); });
      }
      emitExpression(statement.value);
      emitStore(target);
      break;
    }
    case Statement::Kind::Evaluate:
      emitExpression(statement.value);
      emit(Operation::Pop, 0, 0, statement.range, -1);
      break;
    case Statement::Kind::If: {
      emitExpression(statement.value);
      const std::uint32_t toElse = emit(Operation::JumpIfZero, 0, 0, at(statement.value).range, -1);
      emitStatements(statement.body);
      if (statement.otherwise.empty()) {
        patch(toElse);
        break;
      }
      const std::uint32_t toEnd = emit(Operation::Jump, 0, 0, statement.range, 0);
      patch(toElse);
      emitStatements(statement.otherwise);
      patch(toEnd);
      break;
    }
    case Statement::Kind::While: {
      const std::uint32_t begin = here();
      emitExpression(statement.value);
      const std::uint32_t toEnd = emit(Operation::JumpIfZero, 0, 0, at(statement.value).range, -1);
      emitStatements(statement.body);
      emit(Operation::Jump, begin, 0, statement.range, 0);
      patch(toEnd);
      break;
    }
    case Statement::Kind::DoWhile: {
      const std::uint32_t begin = here();
      emitStatements(statement.body);
      emitExpression(statement.value);
      emit(Operation::JumpIfNonZero, begin, 0, at(statement.value).range, -1);
      break;
    }
  }
}

/// Stores the value on the stack; the subscripts of an element lie below it.
void CodeGenerator::emitStore(const ExpressionNode& target) {
  switch (target.binding.kind) {
    case Binding::Kind::Slot:
      emit(Operation::StoreSlot, target.binding.index, 0, target.range, -1);
      break;
    case Binding::Kind::Static:
      emit(Operation::StoreStatic, target.binding.index, 0, target.range, -1);
      break;
    case Binding::Kind::Variable:
      emit(Operation::StoreVariable, target.binding.index, 0, target.range, -1);
      break;
    default:
      ESPALIER_CHECK(target.binding.kind == Binding::Kind::Array);
      emit(Operation::StoreElement, target.binding.index, target.children.size(), target.range,
           -1 - static_cast<int>(target.children.size()));
      break;
  }
}

// ---- expressions

void CodeGenerator::emitExpression(ExpressionIndex index) {
  core::pollWork();
  const ExpressionNode& node = at(index);
  if (values_[index].has_value()) {
    emitConstant(*values_[index], node.range);
    return;
  }
  switch (node.kind) {
    case ExpressionKind::Number:
      emitConstant(node.number, node.range);
      break;
    case ExpressionKind::String:
      emitConstant(static_cast<double>(internString(node.text)), node.range);
      break;
    case ExpressionKind::Name:
      emitName(node);
      break;
    case ExpressionKind::Element:
      std::for_each(node.children.begin(), node.children.end(), [&](ExpressionIndex i) { emitExpression(i); });
      emit(Operation::LoadElement, node.binding.index, node.children.size(), node.range,
           1 - static_cast<int>(node.children.size()));
      break;
    case ExpressionKind::Unary:
      emitExpression(node.children[0]);
      emit(node.operation, 0, 0, node.range, 0);
      break;
    case ExpressionKind::Binary:
      emitOperators(index);
      break;
    case ExpressionKind::Conditional:
      emitConditional(node);
      break;
    case ExpressionKind::Call:
      emitCall(node);
      break;
    case ExpressionKind::Reference:
      ESPALIER_CHECK(node.kind != ExpressionKind::Reference);
      break;
  }
}

void CodeGenerator::emitName(const ExpressionNode& node) {
  switch (node.binding.kind) {
    case Binding::Kind::Slot:
      emit(Operation::LoadSlot, node.binding.index, 0, node.range, 1);
      break;
    case Binding::Kind::Static:
      emit(Operation::LoadStatic, node.binding.index, 0, node.range, 1);
      break;
    case Binding::Kind::Variable:
      emit(Operation::LoadVariable, node.binding.index, 0, node.range, 1);
      break;
    case Binding::Kind::Step:
      emit(Operation::LoadStep, 0, 0, node.range, 1);
      break;
    case Binding::Kind::Length:
      emit(Operation::LoadLength, 0, 0, node.range, 1);
      break;
    default:
      ESPALIER_CHECK_VALUES(node.binding.kind == Binding::Kind::Slot, node.text);
      break;
  }
}

/// Operators with two operands, along their left operands: a sum may have more signs than the stack has room.
void CodeGenerator::emitOperators(ExpressionIndex top) {
  std::vector<ExpressionIndex> chain = operatorChain(model_, top);
  // a constant needs no operands
  chain.erase(std::ranges::find_if(chain, [&](ExpressionIndex i) { return values_[i].has_value(); }), chain.end());
  emitExpression(at(chain.back()).children[0]);
  for (std::size_t i = chain.size(); i-- > 0;) {
    const ExpressionNode& node = at(chain[i]);
    if (node.operation == Operation::LogicalAnd || node.operation == Operation::LogicalOr) {
      emitLogical(node);
    } else {
      emitExpression(node.children[1]);
      emit(node.operation, 0, 0, node.range, -1);
    }
  }
}

/// `&&` and `||` behind their left side. Both sides are evaluated when the right side is simple, because the result is
/// the same; in the reference's modes also when the left side is bare. Otherwise the right side is skipped when the
/// left side decides.
void CodeGenerator::emitLogical(const ExpressionNode& node) {
  const ExpressionNode& left = at(node.children[0]);
  const bool isAnd = node.operation == Operation::LogicalAnd;
  const bool isReferenceOr = isReference() && !isAnd && isCompound(left);
  const bool evaluatesBoth = isReference() && !isCompound(left);
  if (evaluatesBoth || (traits_[node.children[1]].isSimple && !isReferenceOr)) {
    emitExpression(node.children[1]);
    emit(node.operation, 0, 0, node.range, -1);
    return;
  }
  if (isReferenceOr) {
    const std::uint32_t toEnd = emit(Operation::JumpIfOrSkips, 0, 0, left.range, 0);
    emitExpression(node.children[1]);
    emit(Operation::LogicalOr, 0, 0, node.range, -1);
    patch(toEnd);
    return;
  }
  const std::uint32_t toDecided = emit(isAnd ? Operation::JumpIfZero : Operation::JumpIfNonZero, 0, 0, left.range, -1);
  emitExpression(node.children[1]);
  emit(Operation::ToBoolean, 0, 0, node.range, 0);
  const std::uint32_t toEnd = emit(Operation::Jump, 0, 0, node.range, 0);
  patch(toDecided);
  --stackDepth_;  // the other branch leaves no value
  emitConstant(isAnd ? 0.0 : 1.0, node.range);
  patch(toEnd);
}

/// `?:`. In the reference's modes nothing is skipped after a bare condition or a bare first value.
void CodeGenerator::emitConditional(const ExpressionNode& node) {
  const ExpressionIndex condition = node.children[0];
  const ExpressionIndex first = node.children[1];
  const ExpressionIndex second = node.children[2];
  const bool areSimple = traits_[first].isSimple && traits_[second].isSimple;
  emitExpression(condition);
  if (areSimple || (isReference() && !isCompound(at(condition)))) {
    emitExpression(first);
    emitExpression(second);
    emit(Operation::Select, 0, 0, node.range, -2);
    return;
  }
  const std::uint32_t toSecond = emit(Operation::JumpIfZero, 0, 0, at(condition).range, -1);
  emitExpression(first);
  if (isReference() && !isCompound(at(first)) && !traits_[second].isSimple) {
    emitExpression(second);
    emit(Operation::Pop, 0, 0, node.range, -1);
  }
  const std::uint32_t toEnd = emit(Operation::Jump, 0, 0, node.range, 0);
  patch(toSecond);
  --stackDepth_;  // the other branch leaves no value
  emitExpression(second);
  patch(toEnd);
}

// ---- calls

void CodeGenerator::emitCall(const ExpressionNode& node) {
  const auto emitArguments = [&](std::size_t first) {
    for (std::size_t i = first; i < node.children.size(); ++i) {
      emitExpression(node.children[i]);
    }
    return static_cast<int>(node.children.size() - first);
  };
  switch (node.callee) {
    case Callee::Function: {
      const int count = emitArguments(0);
      program_.usesViewVolume =
          program_.usesViewVolume || (node.function >= Function::VvXmin && node.function <= Function::VvZmax);
      emit(Operation::Call, static_cast<std::uint32_t>(node.function), node.children.size(), node.range, 1 - count);
      break;
    }
    case Callee::Print: {
      const int count = emitArguments(1);
      emit(Operation::Print, internString(at(node.children[0]).text), node.children.size() - 1, node.range, 1 - count);
      break;
    }
    case Callee::FileOpen: {
      const FileMode mode = FileMode::parse(at(node.children[1]).text).value_or(FileMode{});
      emit(Operation::FileOpen, internFile(at(node.children[0]).text, mode), mode.bits(), node.range, 1);
      break;
    }
    case Callee::FileClose:
    case Callee::FileFlush:
      emitExpression(node.children[0]);
      emit(node.callee == Callee::FileClose ? Operation::FileClose : Operation::FileFlush, 0, 0, node.range, 0);
      break;
    case Callee::FilePrint: {
      emitExpression(node.children[0]);
      const int count = emitArguments(2);
      emit(Operation::FilePrint, internString(at(node.children[1]).text), node.children.size() - 2, node.range, -count);
      break;
    }
    case Callee::FileScan:
      emitFileScan(node);
      break;
    case Callee::Unknown:
      ESPALIER_CHECK_VALUES(node.callee != Callee::Unknown, node.text);
      break;
  }
}

/// Reads into hidden variables first, then assigns as many targets as numbers were read.
void CodeGenerator::emitFileScan(const ExpressionNode& node) {
  const std::size_t count = node.children.size() - 2;
  emitExpression(node.children[0]);
  emit(Operation::FileScan, internString(at(node.children[1]).text), count, node.range, static_cast<int>(count));
  const std::uint32_t readCount = addStatic("(numbers read)");
  emit(Operation::StoreStatic, readCount, 0, node.range, -1);
  std::vector<std::uint32_t> values(count);
  for (std::size_t i = count; i-- > 0;) {
    values[i] = addStatic("(number read)");
    emit(Operation::StoreStatic, values[i], 0, node.range, -1);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const ExpressionNode& target = at(at(node.children[i + 2]).children[0]);
    emit(Operation::LoadStatic, readCount, 0, node.range, 1);
    emitConstant(static_cast<double>(i + 1), node.range);
    emit(Operation::GreaterEqual, 0, 0, node.range, -1);
    const std::uint32_t toNext = emit(Operation::JumpIfZero, 0, 0, node.range, -1);
    if (target.kind == ExpressionKind::Element) {
      std::for_each(target.children.begin(), target.children.end(), [&](ExpressionIndex j) { emitExpression(j); });
    }
    emit(Operation::LoadStatic, values[i], 0, node.range, 1);
    emitStore(target);
    patch(toNext);
  }
  emit(Operation::LoadStatic, readCount, 0, node.range, 1);
}

}  // namespace espalier::language

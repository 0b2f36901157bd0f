#include "engine/derivation/expressions/evaluator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/check.h"
#include "engine/core/diagnostic.h"
#include "engine/core/work_meter.h"
#include "engine/derivation/expressions/array_element.h"
#include "engine/derivation/expressions/number_format.h"
#include "engine/derivation/expressions/view_functions.h"
#include "engine/language/arithmetic.h"

namespace espalier::derivation {
namespace {

using language::Function;
using language::Instruction;
using language::Operation;

// a loop polls for cancellation where these bits of its iteration count are 0
constexpr std::uint64_t kCancelMask = 0xFFFF;

}  // namespace

Evaluator::Evaluator(const language::Program& program, RandomSource& random, Options options)
    : program_(&program),
      elementary_(program.compatibility),
      random_(&random),
      options_(std::move(options)),
      stack_(program.maximumStack + std::size_t{8}, 0.0),
      hasWarned_(program.code.size(), 0) {
  place_.plant = options_.plant;
}

void Evaluator::attach(PlantState& state) {
  state_ = &state;
}

void Evaluator::enter(InstanceState& instance) {
  instance_ = &instance;
  system_ = &program_->systems[instance.system];
}

void Evaluator::setStep(std::uint64_t step, std::uint64_t failingStep) {
  step_ = static_cast<double>(step);
  place_.step = failingStep;
}

void Evaluator::run(language::CodeRange code, double* frame) {
  const Instruction* const instructions = program_->code.data();
  const Instruction* const end = instructions + code.end;
  const double* constants = program_->constants.data();
  double* variables = instance_->variables.data();
  double* statics = state_->statics.data();
  double* top = stack_.data();  // where the next value goes
  std::uint64_t iterations = 0;
  bool dividedByZero = false;

  for (const Instruction* at = instructions + code.begin; at < end;) {
    const Instruction instruction = *at;
    const std::uint32_t operand = instruction.operand;
    const Instruction* next = at + 1;
    // of the instruction, for messages
    const auto index = [&] { return static_cast<std::uint32_t>(at - instructions); };
    const auto jump = [&] {
      next = instructions + operand;
      // a jump back is a turn of a loop
      if (next <= at) {
        countTurn(++iterations, index());
      }
    };
    switch (instruction.operation) {
      case Operation::Constant:
        *top++ = constants[operand];
        break;
      case Operation::LoadSlot:
        *top++ = frame[operand];
        break;
      case Operation::LoadStatic:
        *top++ = statics[operand];
        break;
      case Operation::LoadVariable:
        *top++ = variables[operand];
        break;
      case Operation::LoadStep:
        *top++ = step_;
        break;
      case Operation::LoadLength:
        *top++ = static_cast<double>(state_->derivationLength);
        break;
      case Operation::LoadElement: {
        top -= instruction.count;
        const double loaded = *element(operand, {top, instruction.count}, index());
        *top++ = loaded;
        break;
      }
      case Operation::StoreSlot:
        frame[operand] = *--top;
        break;
      case Operation::StoreStatic:
        statics[operand] = *--top;
        break;
      case Operation::StoreVariable:
        variables[operand] = *--top;
        break;
      case Operation::StoreElement: {
        const double stored = *--top;
        top -= instruction.count;
        *element(operand, {top, instruction.count}, index()) = stored;
        break;
      }
      case Operation::Pop:
        --top;
        break;
      case Operation::Negate:
        top[-1] = -top[-1];
        break;
      case Operation::Not:
        top[-1] = language::toNumber(!language::isTrue(top[-1]));
        break;
      case Operation::ToBoolean:
        top[-1] = language::toNumber(language::isTrue(top[-1]));
        break;
      case Operation::Add:
        --top;
        top[-1] = top[-1] + top[0];
        break;
      case Operation::Subtract:
        --top;
        top[-1] = top[-1] - top[0];
        break;
      case Operation::Multiply:
        --top;
        top[-1] = top[-1] * top[0];
        break;
      case Operation::Divide:
      case Operation::Modulo:
        --top;
        top[-1] = language::applyBinary(instruction.operation, top[-1], top[0], dividedByZero);
        if (dividedByZero) {
          dividedByZero = false;
          warnOnce(index(), "division by 0; the divisor counts as 1");
        }
        break;
      case Operation::Power:
        --top;
        top[-1] = elementary_.pow(top[-1], top[0]);
        break;
      case Operation::Equal:
        --top;
        top[-1] = language::toNumber(top[-1] == top[0]);
        break;
      case Operation::NotEqual:
        --top;
        top[-1] = language::toNumber(top[-1] != top[0]);
        break;
      case Operation::Less:
        --top;
        top[-1] = language::toNumber(top[-1] < top[0]);
        break;
      case Operation::LessEqual:
        --top;
        top[-1] = language::toNumber(top[-1] <= top[0]);
        break;
      case Operation::Greater:
        --top;
        top[-1] = language::toNumber(top[-1] > top[0]);
        break;
      case Operation::GreaterEqual:
        --top;
        top[-1] = language::toNumber(top[-1] >= top[0]);
        break;
      case Operation::LogicalAnd:
        --top;
        top[-1] = language::toNumber(language::isTrue(top[-1]) && language::isTrue(top[0]));
        break;
      case Operation::LogicalOr:
        --top;
        top[-1] = language::toNumber(language::isTrue(top[-1]) || language::isTrue(top[0]));
        break;
      case Operation::Select:
        top -= 2;
        top[-1] = language::isTrue(top[-1]) ? top[0] : top[1];
        break;
      case Operation::Jump:
        jump();
        break;
      case Operation::JumpIfZero:
        if (!language::isTrue(*--top)) {
          jump();
        }
        break;
      case Operation::JumpIfNonZero:
        if (language::isTrue(*--top)) {
          jump();
        }
        break;
      case Operation::JumpIfOrSkips:
        // with and without the jump, the left value stays
        if (language::orSkips(top[-1])) {
          jump();
        }
        break;
      case Operation::Call: {
        const auto function = static_cast<Function>(operand);
        top -= instruction.count;
        const std::span<const double> arguments(top, instruction.count);
        const double result =
            language::isBasic(function) ? language::callBasic(function, arguments) : call(function, arguments, index());
        *top++ = result;
        break;
      }
      case Operation::Print:
        top -= instruction.count;
        print(program_->strings[operand], {top, instruction.count});
        *top++ = 0.0;
        break;
      case Operation::FileOpen:
        *top++ = openFile(operand, instruction.count, index());
        break;
      case Operation::FileClose:
        closeFile(top[-1], index());
        top[-1] = 0.0;
        break;
      case Operation::FileFlush:
        // the bytes of a step leave when the step is complete
        top[-1] = 0.0;
        break;
      case Operation::FilePrint:
        top -= instruction.count + 1;
        printToFile(top[0], program_->strings[operand], {top + 1, instruction.count}, index());
        *top++ = 0.0;
        break;
      case Operation::FileScan: {
        const double handle = *--top;
        std::fill_n(top, instruction.count, 0.0);
        const double readCount = scanFile(handle, program_->strings[operand], {top, instruction.count}, index());
        top += instruction.count;
        *top++ = readCount;
        break;
      }
    }
    at = next;
  }
}

void Evaluator::countTurn(std::uint64_t iterations, std::uint32_t at) const {
  if (iterations > options_.limits.maximumLoopIterations) {
    failHere(core::SimulationErrorCode::LimitExceeded,
             "a loop ran more than " + std::to_string(options_.limits.maximumLoopIterations) +
                 " iterations (limit loopIterations)",
             program_->codeRanges[at]);
  }
  if ((iterations & kCancelMask) == 0) {
    pollCancelled();
  }
}

inline double* Evaluator::element(std::uint32_t array, std::span<const double> subscripts, std::uint32_t at) {
  const language::ArrayVariable& variable = system_->arrays[array];
  return instance_->elements.data() +
         arrayElement(variable, subscripts, [&](std::size_t i) { warnClamped(variable, i, at); });
}

void Evaluator::warnClamped(const language::ArrayVariable& variable, std::size_t subscript, std::uint32_t at) {
  if (hasWarned_[at] == 0) {
    warnOnce(at, "subscript " + std::to_string(subscript + 1) + " of '" + variable.name +
                     "' is outside the array and is clamped to its ends");
  }
}

double Evaluator::call(Function function, std::span<const double> arguments, std::uint32_t at) {
  if (language::isArithmetic(function)) {
    bool dividedByZero = false;
    const double result = language::callPure(function, arguments, dividedByZero, elementary_);
    if (dividedByZero) {
      warnOnce(at, "division by 0; the divisor counts as 1");
    }
    return result;
  }
  const files::ViewSettings& view = program_->view;
  if (isViewFunction(function)) {
    const std::optional<double> value = viewValue(view, function, arguments);
    if (!value && hasWarned_[at] == 0) {
      warnOnce(at, missingViewFunction(function));
    }
    return value.value_or(0.0);
  }
  switch (function) {
    case Function::Ran:
      return arguments[0] * random_->uniform();
    case Function::Nran:
      return random_->normal(arguments[0], arguments[1]);
    case Function::Bran:
      return random_->beta(arguments[0], arguments[1]);
    case Function::Biran:
      if (arguments[0] > static_cast<double>(options_.limits.maximumLoopIterations)) {
        failHere(core::SimulationErrorCode::LimitExceeded,
                 "biran would draw more than " + std::to_string(options_.limits.maximumLoopIterations) +
                     " numbers (limit loopIterations)",
                 program_->codeRanges[at]);
      }
      return random_->binomial(arguments[0], arguments[1]);
    case Function::Srand:
      random_->seed(arguments[0]);
      return 0.0;
    case Function::Stop:
      // stop(1) means "draw and continue"
      if (arguments[0] != 1.0) {
        state_->isStopped = true;
      }
      return 0.0;
    case Function::GetDerivationLength:
      return static_cast<double>(state_->derivationLength);
    case Function::SetDerivationLength: {
      const double length = arguments[0];
      state_->derivationLength = length >= 1.0 && length < 1.0e18 ? static_cast<std::uint64_t>(length) : 0;
      return static_cast<double>(state_->derivationLength);
    }
    case Function::VvXmin:
    case Function::VvXmax:
    case Function::VvYmin:
    case Function::VvYmax:
    case Function::VvZmin:
    case Function::VvZmax:
      return viewVolume(function);
    case Function::VvScale:
      return view.scaleFactor;
    case Function::Display:
      return 0.0;
    case Function::Play:
      warnOnce(at, "play is refused: a model cannot play sounds");
      return 0.0;
    default:
      break;
  }
  ESPALIER_CHECK_VALUES(false, std::to_string(static_cast<int>(function)));
  return 0.0;
}

double Evaluator::viewVolume(Function function) const {
  const files::ViewSettings& view = program_->view;
  const files::Box& box = view.box ? *view.box : state_->viewVolume;
  // the scale factor narrows the window, not the depth
  const auto bound = [&](double least, double most, double sign) {
    return 0.5 * (least + most) + sign * 0.5 * (most - least) / view.scaleFactor;
  };
  switch (function) {
    case Function::VvXmin:
      return bound(box.minimum.x, box.maximum.x, -1.0);
    case Function::VvXmax:
      return bound(box.minimum.x, box.maximum.x, 1.0);
    case Function::VvYmin:
      return bound(box.minimum.y, box.maximum.y, -1.0);
    case Function::VvYmax:
      return bound(box.minimum.y, box.maximum.y, 1.0);
    case Function::VvZmin:
      return box.minimum.z;
    default:
      return box.maximum.z;
  }
}

void Evaluator::print(const std::string& format, std::span<const double> arguments) const {
  if (options_.messages) {
    options_.messages(core::MessageKind::Printf, formatNumbers(format, arguments));
  }
}

void Evaluator::warnOnce(std::uint32_t at, const std::string& message) {
  if (hasWarned_[at] == 0) {
    hasWarned_[at] = 1;
    warn(message, program_->codeRanges[at]);
  }
}

std::optional<std::pair<std::string, double>> Evaluator::variableRead(const language::Instruction& instruction) const {
  const std::size_t index = instruction.operand;
  switch (instruction.operation) {
    case language::Operation::LoadStatic:
      return std::pair(program_->staticNames[index], state_->statics[index]);
    case language::Operation::LoadVariable:
      return std::pair(system_->variables[index], instance_->variables[index]);
    case language::Operation::LoadStep:
      return std::pair(std::string("Q"), step_);
    case language::Operation::LoadLength:
      return std::pair(std::string("Z"), static_cast<double>(state_->derivationLength));
    default:
      return std::nullopt;
  }
}

void Evaluator::warn(const std::string& message, core::SourceRange range) const {
  if (!options_.messages) {
    return;
  }
  core::Diagnostic diagnostic;
  diagnostic.severity = core::Severity::Warning;
  diagnostic.message = message;
  if (range.begin < range.end) {
    diagnostic.location = program_->sourceMap.locate(range);
  }
  options_.messages(core::MessageKind::Warning, core::formatDiagnostic(diagnostic));
}

void Evaluator::pollCancelled() const {
  // drawing has no flag of its own; the meter stops it
  if ((options_.cancelled != nullptr && options_.cancelled->load(std::memory_order_relaxed)) || core::isWorkStopped()) {
    failHere(core::SimulationErrorCode::Cancelled, "cancelled");
  }
}

}  // namespace espalier::derivation

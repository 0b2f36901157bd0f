#include "engine/derivation/batch/column_evaluator.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <optional>

#include "engine/derivation/batch/unrolled.h"
#include "engine/derivation/expressions/array_element.h"
#include "engine/derivation/expressions/distributions.h"
#include "engine/derivation/expressions/view_functions.h"
#include "engine/language/arithmetic.h"

namespace espalier::derivation {
namespace {

using language::Function;
using language::Operation;

// turns of loops of one run of a block that a batch makes
constexpr std::uint32_t kMostTurns = 4096;

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
      elementary_(program.compatibility),
      slots_(slotCount * kLanes),
      gathered_(slotCount, 0),
      columns_((columnCount + 1) * kLanes),
      active_(kLanes),
      taken_(kLanes),
      drawModules_(kLanes),
      drawPairs_(kLanes),
      drawNumbers_(2 * kLanes),
      powers_(std::size_t{1} << kPowerBits, Power{0, 0, elementary_.pow(0.0, 0.0)}) {}

void ColumnEvaluator::begin(const ColumnInputs& inputs) {
  inputs_ = inputs;
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
    unrolled(lanes_.count, [=](std::size_t i) { column[i] = base[offsets[i]]; });
  };
  switch (source.kind) {
    case SlotSource::Kind::Own: {
      const double* const own = lanes_.ownParameters + source.position;
      const std::uint32_t* const sites = lanes_.sites;
      const std::uint32_t* const offsets = lanes_.siteOffsets;
      unrolled(lanes_.count, [=](std::size_t i) { column[i] = own[offsets[sites[i]]]; });
      break;
    }
    case SlotSource::Kind::Left:
      gather(lanes_.parameters, lanes_.left);
      break;
    case SlotSource::Kind::Right:
      gather(lanes_.parameters, lanes_.right);
      break;
    case SlotSource::Kind::Searched: {
      const double* const parameters = lanes_.parameters + source.position;
      const std::uint64_t* const rows = lanes_.rows + source.element;
      const std::uint64_t* const left = lanes_.left;
      unrolled(lanes_.count, [=](std::size_t i) { column[i] = parameters[rows[left[i]]]; });
      break;
    }
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
    case ColumnOperand::Kind::Variable:
      return {nullptr, inputs_.variables[operand.index]};
    case ColumnOperand::Kind::Step:
      return {nullptr, inputs_.step};
    case ColumnOperand::Kind::Length:
      return {nullptr, inputs_.length};
  }
  return {nullptr, operand.constant};
}

ColumnValue ColumnEvaluator::value(const ColumnCode& expression) {
  run(expression);
  return operand(expression.result);
}

void ColumnEvaluator::run(const ColumnCode& code) {
  if (!code.stretches.empty()) {
    runStretches(code);
    return;
  }
  for (const ColumnInstruction& instruction : code.instructions) {
    run(instruction);
  }
}

const std::uint64_t* ColumnEvaluator::storing(const ColumnCode& code, std::uint32_t local) const {
  return code.stretches.empty() ? nullptr : stored_.data() + local * kLanes;
}

void ColumnEvaluator::runStretches(const ColumnCode& code) {
  const std::size_t count = code.stretches.size();
  if (waitCounts_.size() <= count) {
    waiting_.resize((count + 1) * kLanes, 0);
    waitCounts_.resize(count + 1, 0);
  }
  for (const std::uint32_t local : code.stores) {
    stored_.resize(std::max(stored_.size(), (local + std::size_t{1}) * kLanes));
    std::fill_n(stored_.begin() + static_cast<std::ptrdiff_t>(local * kLanes), lanes_.count, Mask{0});
  }
  turns_ = 0;
  std::fill_n(active_.begin(), lanes_.count, ~Mask{0});
  wait(0, active_.data());
  // the first stretch with waiting lanes: all lanes of a branch or a loop come together again behind it
  for (std::size_t stretch = 0; stretch < count;) {
    if (waitCounts_[stretch] == 0) {
      ++stretch;
      continue;
    }
    Mask* const waiting = waiting_.data() + stretch * kLanes;
    std::copy_n(waiting, lanes_.count, active_.begin());
    std::fill_n(waiting, lanes_.count, Mask{0});
    mask_ = waitCounts_[stretch] == lanes_.count ? nullptr : active_.data();
    waitCounts_[stretch] = 0;
    for (std::uint32_t i = stretch == 0 ? 0 : code.stretches[stretch - 1].end; i < code.stretches[stretch].end; ++i) {
      run(code.instructions[i]);
    }
    leaveStretch(code, stretch);
    const ColumnStretch& left = code.stretches[stretch];
    stretch = left.jump != Operation::Pop && left.target <= stretch ? left.target : stretch + 1;
  }
  // the end
  std::fill_n(waiting_.begin() + static_cast<std::ptrdiff_t>(count * kLanes), lanes_.count, Mask{0});
  waitCounts_[count] = 0;
  mask_ = nullptr;
}

void ColumnEvaluator::leaveStretch(const ColumnCode& code, std::size_t number) {
  const ColumnStretch& stretch = code.stretches[number];
  if (stretch.jump == Operation::Pop) {
    wait(number + 1, active_.data());
    return;
  }
  // a loop that turns so often that the Evaluator looks at its limit and at `cancelled`
  if (stretch.target <= number && ++turns_ > kMostTurns) {
    isUnusual_ = true;
    return;
  }
  if (stretch.jump == Operation::Jump) {
    wait(stretch.target, active_.data());
    return;
  }
  const ColumnValue test = operand(stretch.test);
  for (std::size_t i = 0; i < lanes_.count; ++i) {
    const double value = at(test, i);
    const bool jumps = stretch.jump == Operation::JumpIfZero      ? !language::isTrue(value)
                       : stretch.jump == Operation::JumpIfNonZero ? language::isTrue(value)
                                                                  : language::orSkips(value);
    taken_[i] = jumps ? active_[i] : 0;
    active_[i] &= ~taken_[i];
  }
  wait(stretch.target, taken_.data());
  wait(number + 1, active_.data());
}

void ColumnEvaluator::wait(std::size_t stretch, const Mask* lanes) {
  Mask* const waiting = waiting_.data() + stretch * kLanes;
  Mask count = 0;
  for (std::size_t i = 0; i < lanes_.count; ++i) {
    waiting[i] |= lanes[i];
    count += lanes[i] & 1U;
  }
  waitCounts_[stretch] += count;
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
    case Operation::Divide:
      divide(instruction, target, a, b);
      return;
    case Operation::Power:
      raise(target, a, b);
      return;
    case Operation::StoreStatic:
      move(instruction, target, a);
      return;
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
    case Operation::Modulo:
      if (mask_ == nullptr) {
        takeRemainders(instruction, target, a, b);
      } else {
        runOneByOne(instruction, target, a, b);
      }
      return;
    case Operation::LoadElement:
      if (!loadElements(instruction, target)) {
        runOneByOne(instruction, target, a, b);
      }
      return;
    default:
      runOneByOne(instruction, target, a, b);
      return;
  }
}

void ColumnEvaluator::divide(const ColumnInstruction& instruction, double* target, const ColumnValue& a,
                             const ColumnValue& b) {
  bool dividesByZero = false;
  if (b.values == nullptr) {
    dividesByZero = b.constant == 0.0;
  } else if (mask_ == nullptr) {
    for (std::size_t i = 0; i < lanes_.count; ++i) {
      dividesByZero |= b.values[i] == 0.0;
    }
  } else {
    for (std::size_t i = 0; i < lanes_.count; ++i) {
      dividesByZero |= (b.values[i] == 0.0) & (mask_[i] != 0);
    }
  }
  if (dividesByZero) {
    noteWarning(instruction.instruction);
    forEach(target, a, b, lanes_.count, [](double x, double y) { return x / (y == 0.0 ? 1.0 : y); });
  } else {
    forEach(target, a, b, lanes_.count, [](double x, double y) { return x / y; });
  }
}

void ColumnEvaluator::takeRemainders(const ColumnInstruction& instruction, double* target, const ColumnValue& a,
                                     const ColumnValue& b) {
  bool dividesByZero = false;
  forEach(target, a, b, lanes_.count,
          [&](double x, double y) { return language::truncateModulo(x, y, dividesByZero); });
  if (dividesByZero) {
    noteWarning(instruction.instruction);
  }
}

void ColumnEvaluator::move(const ColumnInstruction& instruction, double* target, const ColumnValue& from) {
  if (mask_ == nullptr) {
    for (std::size_t i = 0; i < lanes_.count; ++i) {
      target[i] = at(from, i);
    }
  } else {
    for (std::size_t i = 0; i < lanes_.count; ++i) {
      target[i] = mask_[i] != 0 ? at(from, i) : target[i];
    }
  }
  if (instruction.isStore) {
    Mask* const stored = stored_.data() + instruction.target * kLanes;
    for (std::size_t i = 0; i < lanes_.count; ++i) {
      stored[i] |= mask_ == nullptr ? ~Mask{0} : mask_[i];
    }
  }
}

double ColumnEvaluator::power(double x, double y) {
  // modules of one kind often have equal values
  const auto base = std::bit_cast<std::uint64_t>(x);
  const auto exponent = std::bit_cast<std::uint64_t>(y);
  Power& known = powers_[placeOfPower(base, exponent)];
  if (known.base != base || known.exponent != exponent) [[unlikely]] {
    known = {base, exponent, elementary_.pow(x, y)};
  }
  return known.value;
}

void ColumnEvaluator::raise(double* target, const ColumnValue& a, const ColumnValue& b) {
  // local pointers: the compiler would read members again after each write, which may have changed them
  Power* const powers = powers_.data();
  const std::size_t count = lanes_.count;
  if (mask_ == nullptr && a.values != nullptr && b.values == nullptr) {
    const auto exponent = std::bit_cast<std::uint64_t>(b.constant);
    for (std::size_t i = 0; i < count; ++i) {
      const auto base = std::bit_cast<std::uint64_t>(a.values[i]);
      const Power& known = powers[placeOfPower(base, exponent)];
      target[i] = ((known.base == base) & (known.exponent == exponent)) ? known.value : power(a.values[i], b.constant);
    }
    return;
  }
  if (mask_ == nullptr) {
    forEach(target, a, b, count, [this](double x, double y) { return power(x, y); });
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (isActive(i)) {
      target[i] = power(at(a, i), at(b, i));
    }
  }
}

/// The elements of an array, when no lane has a subscript outside. Otherwise nothing is done: false.
bool ColumnEvaluator::loadElements(const ColumnInstruction& instruction, double* target) {
  const language::ArrayVariable& variable = program_->systems.front().arrays[instruction.function];
  std::array<std::uint32_t, kLanes> places;
  std::fill_n(places.begin(), lanes_.count, variable.firstElement);
  std::uint32_t step = 1;  // between two elements of the present dimension
  for (std::size_t i = variable.dimensions.size(); i > 0; --i) {
    const std::uint32_t size = variable.dimensions[i - 1];
    if (size > std::uint32_t{std::numeric_limits<std::int32_t>::max()}) {
      return false;
    }
    if (i <= instruction.count) {
      const ColumnValue subscript = operand(instruction.operands[i - 1]);
      std::size_t inside = 0;
      for (std::size_t lane = 0; lane < lanes_.count; ++lane) {
        const double value = at(subscript, lane);
        // a value that truncates to 0 is inside, too
        const bool isInside = value > -1.0 && value < static_cast<double>(size);
        places[lane] += step * static_cast<std::uint32_t>(static_cast<std::int32_t>(isInside ? value : 0.0));
        inside += isInside || !isActive(lane) ? 1 : 0;
      }
      if (inside < lanes_.count) {
        return false;
      }
    }
    step *= size;
  }
  for (std::size_t lane = 0; lane < lanes_.count; ++lane) {
    target[lane] = inputs_.elements[places[lane]];
  }
  return true;
}

double ColumnEvaluator::element(const ColumnInstruction& instruction, std::span<const double> subscripts) {
  const language::ArrayVariable& variable = program_->systems.front().arrays[instruction.function];
  return inputs_
      .elements[arrayElement(variable, subscripts, [&](std::size_t) { noteWarning(instruction.instruction); })];
}

/// Makes the next two draws of all lanes that do not know them yet.
void ColumnEvaluator::prepareDraws() {
  std::size_t count = 0;
  const auto forUnknown = [&](auto&& take) {
    count = 0;
    for (std::size_t lane = 0; lane < lanes_.count; ++lane) {
      ModuleDraws& draws = lanes_.draws[lanes_.sites[lane]];
      if (draws.pair != draws.count / 2 && isActive(lane)) {
        take(draws, lane);
        ++count;
      }
    }
  };
  forUnknown([&](const ModuleDraws& draws, std::size_t lane) {
    drawModules_[count] = lanes_.modules[lane];
    drawPairs_[count] = draws.count / 2;
  });
  inputs_.draws.uniformPairs(core::DrawDomain::Production, static_cast<std::uint32_t>(inputs_.step), count,
                             drawModules_.data(), drawPairs_.data(), drawNumbers_.data());
  forUnknown([&](ModuleDraws& draws, std::size_t) {
    draws.pair = drawPairs_[count];
    draws.numbers = {drawNumbers_[2 * count], drawNumbers_[2 * count + 1]};
  });
}

double ColumnEvaluator::draw(Function function, std::span<const double> arguments, std::size_t lane) {
  // each module counts its draws, so jumps and rejected draws of other lanes change nothing
  const auto uniform = [&, &draws = lanes_.draws[lanes_.sites[lane]]] {
    const std::uint32_t number = draws.count++;
    if (draws.pair != number / 2) {
      draws.pair = number / 2;
      draws.numbers = core::CounterRandom::pairOf(inputs_.draws.block(
          core::DrawDomain::Production, static_cast<std::uint32_t>(inputs_.step), lanes_.modules[lane], draws.pair));
    }
    return draws.numbers[number % 2];
  };
  switch (function) {
    case Function::Nran: {
      const NormalPair pair = drawNormalPair(uniform, elementary_);
      return arguments[0] + arguments[1] * pair.second * pair.factor;
    }
    case Function::Bran:
      return drawBeta(uniform, elementary_, arguments[0], arguments[1]);
    default:
      return arguments[0] * uniform();
  }
}

void ColumnEvaluator::runOneByOne(const ColumnInstruction& instruction, double* target, const ColumnValue& a,
                                  const ColumnValue& b) {
  const auto function = static_cast<Function>(instruction.function);
  const ColumnValue c = instruction.count > 2 ? operand(instruction.operands[2]) : ColumnValue{};
  const ColumnValue d = instruction.count > 3 ? operand(instruction.operands[3]) : ColumnValue{};
  std::array<double, 4> numbers{};
  const std::span<const double> arguments(numbers.data(), instruction.count);
  bool dividesByZero = false;
  if (instruction.operation == Operation::Call && language::drawsRandom(function)) {
    prepareDraws();
  }
  for (std::size_t i = 0; i < lanes_.count; ++i) {
    if (!isActive(i)) {
      continue;
    }
    numbers = {at(a, i), at(b, i), at(c, i), at(d, i)};
    if (instruction.operation == Operation::LoadElement) {
      target[i] = element(instruction, arguments);
    } else if (instruction.operation != Operation::Call) {
      target[i] = language::applyBinary(instruction.operation, numbers[0], numbers[1], dividesByZero, elementary_);
    } else if (language::drawsRandom(function)) {
      target[i] = draw(function, arguments, i);
    } else if (isViewFunction(function)) {
      const std::optional<double> value = viewValue(program_->view, function, arguments);
      if (!value) {
        noteWarning(instruction.instruction);
      }
      target[i] = value.value_or(0.0);
    } else {
      target[i] = language::callPure(function, arguments, dividesByZero, elementary_);
    }
  }
  if (dividesByZero) {
    noteWarning(instruction.instruction);
  }
}

}  // namespace espalier::derivation

#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "engine/core/elementary.h"
#include "engine/language/program.h"

namespace espalier::language {

/// The scalar arithmetic of expressions, shared by constant folding and by the evaluator of engine/derivation so that
/// both give identical doubles. Nothing here depends on a plant or a view file.

/// Whether a value counts as true: every value except 0 (NaN is true).
[[nodiscard]] constexpr bool isTrue(double value) {
  return value != 0.0;
}

/// A truth value as a number, 0 or 1.
[[nodiscard]] constexpr double toNumber(bool truth) {
  return truth ? 1.0 : 0.0;
}

/// a / b; a division by 0 divides by 1 and sets `dividedByZero`, which is never cleared.
[[nodiscard]] inline double divide(double a, double b, bool& dividedByZero) {
  if (b == 0.0) {
    dividedByZero = true;
    return a;
  }
  return a / b;
}

/// a % b of both operands truncated towards 0; the result has the sign of a, and is never -0. A divisor that truncates
/// to 0 counts as 1 and sets `dividedByZero`.
[[nodiscard]] inline double truncateModulo(double a, double b, bool& dividedByZero) {
  // numbers that are small as integers: the same result without calls of the C library
  constexpr double kLarge = 2147483648.0;
  if (std::fabs(a) < kLarge && std::fabs(b) < kLarge && std::fabs(b) >= 1.0) {
    return static_cast<std::int32_t>(a) % static_cast<std::int32_t>(b);
  }
  const double divisor = std::trunc(b);
  if (divisor == 0.0) {
    dividedByZero = true;
    return 0.0;
  }
  return std::fmod(std::trunc(a), divisor) + 0.0;
}

/// Whether the reference's `||` skips its right side after a compound left side with this value. It does when the value
/// as a 32-bit integer is not a multiple of 256.
[[nodiscard]] inline bool orSkips(double value) {
  if (!(std::fabs(value) < 2147483648.0)) {
    return false;
  }
  return static_cast<std::int64_t>(value) % 256 != 0;
}

/// Negate, Not or ToBoolean.
[[nodiscard]] inline double applyUnary(Operation operation, double a) {
  switch (operation) {
    case Operation::Not:
      return toNumber(a == 0.0);
    case Operation::ToBoolean:
      return toNumber(isTrue(a));
    default:
      return -a;
  }
}

/// One of the operations Add to LogicalOr of instruction.def; a is the deeper operand. `dividedByZero` is set, never
/// cleared. `elementary` are the functions of the mode.
[[nodiscard]] inline double applyBinary(Operation operation, double a, double b, bool& dividedByZero,
                                        core::Elementary elementary = {}) {
  switch (operation) {
    case Operation::Add:
      return a + b;
    case Operation::Subtract:
      return a - b;
    case Operation::Multiply:
      return a * b;
    case Operation::Divide:
      return divide(a, b, dividedByZero);
    case Operation::Modulo:
      return truncateModulo(a, b, dividedByZero);
    case Operation::Power:
      return elementary.pow(a, b);
    case Operation::Equal:
      return toNumber(a == b);
    case Operation::NotEqual:
      return toNumber(a != b);
    case Operation::Less:
      return toNumber(a < b);
    case Operation::LessEqual:
      return toNumber(a <= b);
    case Operation::Greater:
      return toNumber(a > b);
    case Operation::GreaterEqual:
      return toNumber(a >= b);
    case Operation::LogicalAnd:
      return toNumber(isTrue(a) && isTrue(b));
    case Operation::LogicalOr:
      return toNumber(isTrue(a) || isTrue(b));
    default:
      return 0.0;
  }
}

/// Whether callPure computes the function: Sin to Clamp of function.def. The other pure functions (func, curveX, inblob
/// and so on) need the view file.
[[nodiscard]] constexpr bool isArithmetic(Function function) {
  return function <= Function::Clamp;
}

/// Whether callBasic computes the function: Sqrt to Max of function.def.
[[nodiscard]] constexpr bool isBasic(Function function) {
  return function >= Function::Sqrt && function <= Function::Max;
}

/// The value of a function that costs as little as an operator.
[[nodiscard]] inline double callBasic(Function function, std::span<const double> arguments) {
  const double x = arguments[0];
  switch (function) {
    case Function::Sqrt:
      return std::sqrt(x);
    case Function::Fabs:
      return std::fabs(x);
    case Function::Floor:
      return std::floor(x);
    case Function::Ceil:
      return std::ceil(x);
    case Function::Sign:
      return x > 0.0 ? 1.0 : (x < 0.0 ? -1.0 : 0.0);
    case Function::Trunc:
      return std::floor(x + 0.5);
    case Function::Min:
      return std::min(x, arguments[1]);
    default:
      return std::max(x, arguments[1]);
  }
}

/// The value of an arithmetic function, the first argument first; the argument count is one that function.def allows.
/// Angles are in degrees. mod(x, 0) counts as mod(x, 1) and sets `dividedByZero`.
/// `elementary` are the functions of the mode.
[[nodiscard]] double callPure(Function function, std::span<const double> arguments, bool& dividedByZero,
                              core::Elementary elementary = {});

struct FunctionInfo {
  const char* name = "";
  std::uint16_t least = 0;  // argument counts
  std::uint16_t most = 0;
  bool isPure = false;       // depends on its arguments (and the view file) alone
  const char* usage = "";    // its name with its arguments
  const char* meaning = "";  // for people; `[!]` marks what surprises
};

/// A call that the grammar knows, as printf: its arguments are no plain expressions.
struct SpecialFunctionInfo {
  const char* name = "";
  const char* usage = "";
  const char* meaning = "";
};

/// The row of function.def.
[[nodiscard]] const FunctionInfo& functionInfo(Function function);

/// All rows, indexed by Function.
[[nodiscard]] std::span<const FunctionInfo> allFunctions();

/// The special rows of function.def.
[[nodiscard]] std::span<const SpecialFunctionInfo> specialFunctions();

/// Whether the function draws random numbers: ran, nran, bran, biran.
[[nodiscard]] constexpr bool drawsRandom(Function function) {
  return function == Function::Ran || function == Function::Nran || function == Function::Bran ||
         function == Function::Biran;
}

}  // namespace espalier::language

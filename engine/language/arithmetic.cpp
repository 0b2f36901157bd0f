#include "engine/language/arithmetic.h"

#include <algorithm>
#include <array>
#include <numbers>

#include "engine/core/check.h"

namespace espalier::language {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

constexpr std::array kFunctions{
#define ESPALIER_FUNCTION(name, text, least, most, isPure, usage, meaning) \
  FunctionInfo{text, least, most, isPure, usage, meaning},
#include "engine/language/function.def"
};

constexpr std::array kSpecialFunctions{
#define ESPALIER_SPECIAL_FUNCTION(callee, text, usage, meaning) SpecialFunctionInfo{text, usage, meaning},
#include "engine/language/function.def"
};

// the remainder with the sign of the divisor
double floorModulo(double x, double divisor, bool& dividedByZero) {
  if (divisor == 0.0) {
    dividedByZero = true;
    divisor = 1.0;
  }
  const double remainder = std::fmod(x, divisor);
  return remainder != 0.0 && (remainder < 0.0) != (divisor < 0.0) ? remainder + divisor : remainder + 0.0;
}

}  // namespace

std::span<const FunctionInfo> allFunctions() {
  return kFunctions;
}

std::span<const SpecialFunctionInfo> specialFunctions() {
  return kSpecialFunctions;
}

const FunctionInfo& functionInfo(Function function) {
  return kFunctions[static_cast<std::size_t>(function)];
}

double callPure(Function function, std::span<const double> arguments, bool& dividedByZero,
                core::Elementary elementary) {
  const double x = arguments[0];
  switch (function) {
    case Function::Sin:
      return elementary.sin(x * kRadiansPerDegree);
    case Function::Cos:
      return elementary.cos(x * kRadiansPerDegree);
    case Function::Tan:
      return elementary.tan(x * kRadiansPerDegree);
    case Function::Asin:
      return elementary.asin(x) * kDegreesPerRadian;
    case Function::Acos:
      return elementary.acos(x) * kDegreesPerRadian;
    case Function::Atan:
      return elementary.atan(arguments.back()) * kDegreesPerRadian;
    case Function::Atan2:
      return elementary.atan2(x, arguments[1]) * kDegreesPerRadian;
    case Function::Exp:
      return elementary.exp(x);
    case Function::Log:
      return elementary.log(x);
    case Function::Sqrt:
    case Function::Fabs:
    case Function::Floor:
    case Function::Ceil:
    case Function::Sign:
    case Function::Trunc:
    case Function::Min:
    case Function::Max:
      return callBasic(function, arguments);
    case Function::Mod:
      return floorModulo(x, arguments[1], dividedByZero);
    case Function::Hypot:
      return elementary.hypot(x, arguments[1]);
    case Function::Clamp:
      return std::min(std::max(x, arguments[1]), arguments[2]);
    default:
      ESPALIER_CHECK_VALUES(isArithmetic(function), std::string(functionInfo(function).name));
      return 0.0;
  }
}

}  // namespace espalier::language

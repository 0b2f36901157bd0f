#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/hash.h"
#include "engine/core/random.h"

namespace espalier::test {

/// An elementary function, where most of its arguments lie in tests, and the hash of its values there.
struct ElementaryCase {
  std::string name;
  double (*unary)(double) = nullptr;
  double (*binary)(double, double) = nullptr;
  double low = 0.0;
  double high = 0.0;
  std::uint64_t bits = 0;  // a change of these changes the bits of plants: CHANGELOG.md names the reason
};

inline std::vector<ElementaryCase> elementaryCases() {
  const auto unary = [](const char* name, double (*function)(double), double low, double high, std::uint64_t bits) {
    return ElementaryCase{.name = name, .unary = function, .low = low, .high = high, .bits = bits};
  };
  const auto binary = [](const char* name, double (*function)(double, double), double low, double high,
                         std::uint64_t bits) {
    return ElementaryCase{.name = name, .binary = function, .low = low, .high = high, .bits = bits};
  };
  return {
      unary("acos", core::acos, -1.0, 1.0, 0xfd26ba60962c6207U),
      unary("asin", core::asin, -1.0, 1.0, 0xf59f76edb560b7e8U),
      unary("atan", core::atan, -5.0, 5.0, 0x35e1fe9a71a86f3fU),
      unary("cos", core::cos, -7.0, 7.0, 0x079512470f93d2b7U),
      unary("exp", core::exp, -20.0, 20.0, 0x2a1ee11f7190d25cU),
      unary("exp2", core::exp2, -20.0, 20.0, 0x08e4d4d025975805U),
      unary("expm1", core::expm1, -5.0, 5.0, 0xc2a59c76f4147801U),
      unary("log", core::log, 0.0, 4.0, 0x36b63c9dc36c5951U),
      unary("log10", core::log10, 0.0, 4.0, 0x7371d9e1acde77a6U),
      unary("log1p", core::log1p, -1.0, 4.0, 0x4d4623abb3228654U),
      unary("log2", core::log2, 0.0, 4.0, 0xb12e6e6d47e2877bU),
      unary("sin", core::sin, -7.0, 7.0, 0x931aa4a0538fdd49U),
      unary("tan", core::tan, -7.0, 7.0, 0x9faaa0477e0cafb7U),
      binary("atan2", core::atan2, -5.0, 5.0, 0xd62baf714809e253U),
      binary("hypot", core::hypot, -5.0, 5.0, 0x1fd8f31ef009c140U),
      binary("pow", core::pow, 0.0, 4.0, 0x3771220d60ed42e8U),
  };
}

/// Argument number `place` of call `index`: three of four calls are in the range of the case, the fourth has any
/// exponent and sign.
inline double elementaryArgument(const ElementaryCase& entry, std::uint64_t index, std::uint32_t place) {
  const core::CounterRandom random(7, 0);
  const auto uniform = [&](std::uint32_t draw) {
    return random.uniform(core::DrawDomain::Environment, 0, index, 4 * place + draw);
  };
  if (index % 4 != 3) {
    return entry.low + (entry.high - entry.low) * uniform(0);
  }
  const double size = std::ldexp(1.0 + uniform(1), static_cast<int>(uniform(2) * 2098.0) - 1074);
  return uniform(3) < 0.5 ? size : -size;
}

inline double elementaryValue(const ElementaryCase& entry, std::uint64_t index) {
  const double x = elementaryArgument(entry, index, 0);
  return entry.unary != nullptr ? entry.unary(x) : entry.binary(x, elementaryArgument(entry, index, 1));
}

/// The hash of 100,000 values. NaN counts as 0: processors give it different signs.
inline std::uint64_t elementaryBits(const ElementaryCase& entry) {
  core::Hasher hash;
  for (std::uint64_t index = 0; index < 100'000; ++index) {
    const double value = elementaryValue(entry, index);
    hash.number(std::isnan(value) ? 0.0 : value);
  }
  return hash.value();
}

}  // namespace espalier::test

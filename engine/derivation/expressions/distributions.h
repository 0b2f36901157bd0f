#pragma once

#include <algorithm>
#include <cmath>

#include "engine/core/elementary.h"

namespace espalier::derivation {

/// A point of the unit disc and what turns its coordinates into two normally distributed numbers.
struct NormalPair {
  double first = 0.0;
  double second = 0.0;
  double factor = 0.0;
};

/// Two standard normal numbers by the polar Box-Muller method, from draws of `uniform` in [0, 1).
template <typename Uniform>
[[nodiscard]] NormalPair drawNormalPair(Uniform uniform, const core::Elementary& elementary) {
  NormalPair pair;
  double square = 0.0;
  do {
    pair.first = 2.0 * uniform() - 1.0;
    pair.second = 2.0 * uniform() - 1.0;
    square = pair.first * pair.first + pair.second * pair.second;
  } while (square >= 1.0 || square == 0.0);
  pair.factor = std::sqrt(-2.0 * elementary.log(square) / square);
  return pair;
}

/// A beta distributed number: algorithm BA of Cheng (1978).
template <typename Uniform>
[[nodiscard]] double drawBeta(Uniform uniform, const core::Elementary& elementary, double a, double b) {
  // a rejection method gives up after so many draws, because some arguments never end it
  constexpr int kMaximumTries = 100'000;
  const double sum = a + b;
  const double smaller = std::min(a, b);
  const double lambda = smaller <= 1.0 ? smaller : std::sqrt((2.0 * a * b - sum) / (sum - 2.0));
  const double u = a + lambda;
  double result = 0.0;
  for (int i = 0; i < kMaximumTries; ++i) {
    double u1 = uniform();
    for (int j = 0; u1 == 0.0 && j < kMaximumTries; ++j) {
      u1 = uniform();
    }
    double u2 = uniform();
    for (int j = 0; u2 == 0.0 && j < kMaximumTries; ++j) {
      u2 = uniform();
    }
    const double v = elementary.log(u1 / (1.0 - u1)) / lambda;
    const double y = a * elementary.exp(v);
    // for a very large y the quotient is 1
    result = std::isinf(y) ? 1.0 : y / (b + y);
    if (!(sum * elementary.log(sum / (b + y)) + u * v - elementary.log(4.0) < elementary.log(u1 * u1 * u2))) {
      break;
    }
  }
  return result;
}

}  // namespace espalier::derivation

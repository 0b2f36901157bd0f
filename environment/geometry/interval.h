#pragma once

namespace espalier::environment {

/// Distance of a coordinate from the interval [low, high]; 0 inside.
[[nodiscard]] constexpr double outside(double value, double low, double high) {
  return value < low ? low - value : value > high ? value - high : 0.0;
}

}  // namespace espalier::environment

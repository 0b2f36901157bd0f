#pragma once

#include <algorithm>
#include <limits>

namespace espalier::environment {

/// A number as the published environment programs hold it. Beyond the range of floats it is the largest float.
[[nodiscard]] inline float toFloat(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(value, -kLargest, kLargest));
}

}  // namespace espalier::environment

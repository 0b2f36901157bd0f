#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "engine/language/program.h"

namespace espalier::derivation {

/// The place of an element among all array elements of an instance. Subscripts are truncated and clamped to the array;
/// missing ones count as 0. Calls onClamped(i) for each subscript i that lies outside.
template <typename OnClamped>
[[nodiscard]] std::size_t arrayElement(const language::ArrayVariable& variable, std::span<const double> subscripts,
                                       OnClamped onClamped) {
  std::size_t index = 0;
  for (std::size_t i = 0; i < variable.dimensions.size(); ++i) {
    const double last = static_cast<double>(variable.dimensions[i]) - 1.0;
    const double subscript = i < subscripts.size() ? std::trunc(subscripts[i]) : 0.0;
    const double clamped = std::isnan(subscript) ? 0.0 : std::clamp(subscript, 0.0, last);
    if (!(clamped == subscript)) {
      onClamped(i);
    }
    index = index * variable.dimensions[i] + static_cast<std::size_t>(clamped);
  }
  return variable.firstElement + index;
}

}  // namespace espalier::derivation

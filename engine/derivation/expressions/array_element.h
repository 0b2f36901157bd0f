#pragma once

#include <cstddef>
#include <cstdint>
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
    const std::uint32_t dimension = variable.dimensions[i];
    const double subscript = i < subscripts.size() ? subscripts[i] : 0.0;
    index *= dimension;
    if (subscript >= 0.0 && subscript < dimension) [[likely]] {
      // the conversion truncates
      index += static_cast<std::uint32_t>(subscript);
    } else if (!(subscript > -1.0 && subscript < 0.0)) {
      index += subscript >= dimension ? dimension - 1 : 0;
      onClamped(i);
    }
  }
  return variable.firstElement + index;
}

}  // namespace espalier::derivation

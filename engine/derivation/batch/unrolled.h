#pragma once

#include <cstddef>

namespace espalier::derivation {

/// Calls `f(i)` for 0 <= i < count, four times in a turn of the loop. For loops over gathered elements, which no vector
/// instruction does well: counting took two of their seven instructions.
template <typename F>
[[gnu::always_inline]] inline void unrolled(std::size_t count, const F& f) {
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    f(i);
    f(i + 1);
    f(i + 2);
    f(i + 3);
  }
  for (; i < count; ++i) {
    f(i);
  }
}

}  // namespace espalier::derivation

#pragma once

namespace espalier {

// Compiled with a sanitizer, the program is several times slower and needs several times the memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsSanitized = true;
#else
constexpr bool kIsSanitized = false;
#endif

}  // namespace espalier

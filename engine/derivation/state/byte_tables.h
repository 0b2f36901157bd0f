#pragma once

// Tables of bytes by module type in vector registers, for loops that look at sixteen modules of a string at a time.
// Only .cpp files with such loops include this.

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/core/identifiers.h"

#if defined(__x86_64__)
#include <immintrin.h>

/// The instructions that a vector loop and the functions inlined into it may use.
#define ESPALIER_VECTOR_TARGET gnu::target("avx2,bmi,popcnt")
#define ESPALIER_VECTOR_INLINE [[ESPALIER_VECTOR_TARGET, gnu::always_inline]] inline
#endif

namespace espalier::derivation {

/// The most module types that the tables hold.
inline constexpr std::size_t kMostByteTypes = 64;
/// A byte for each module type.
using ByteTable = std::array<std::uint8_t, kMostByteTypes>;

/// The blocks of 16 types that a model needs, rounded up to 1, 2 or 4. 0 when it has too many types or the processor
/// lacks the instructions.
[[nodiscard]] inline std::uint32_t byteTableBlocks(std::size_t typeCount) {
#if defined(__x86_64__)
  if (typeCount <= kMostByteTypes && __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi") != 0 &&
      __builtin_cpu_supports("popcnt") != 0) {
    return typeCount <= 16 ? 1 : (typeCount <= 32 ? 2 : 4);
  }
#else
  static_cast<void>(typeCount);
#endif
  return 0;
}

#if defined(__x86_64__)

/// The first 16 * kBlocks bytes of a ByteTable in registers.
template <std::uint32_t kBlocks>
struct ByteRegisters {
  __m128i blocks[kBlocks];
};

template <std::uint32_t kBlocks>
ESPALIER_VECTOR_INLINE ByteRegisters<kBlocks> loadTable(const ByteTable& bytes) {
  ByteRegisters<kBlocks> table;
  for (std::uint32_t i = 0; i < kBlocks; ++i) {
    table.blocks[i] = _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes.data() + std::size_t{16} * i));
  }
  return table;
}

/// Sixteen module types, each less than 256, as bytes.
ESPALIER_VECTOR_INLINE __m128i loadTypes(const core::ModuleTypeId* types) {
  return _mm_packus_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(types)),
                          _mm_loadu_si128(reinterpret_cast<const __m128i*>(types + 8)));
}

/// The bytes of sixteen types, each less than 16 * kBlocks.
template <std::uint32_t kBlocks>
ESPALIER_VECTOR_INLINE __m128i lookUp(const ByteRegisters<kBlocks>& table, __m128i types) {
  if constexpr (kBlocks == 1) {
    return _mm_shuffle_epi8(table.blocks[0], types);
  } else {
    // the top bit of each byte decides the blend
    const __m128i bit4 = _mm_slli_epi16(types, 3);
    const __m128i low =
        _mm_blendv_epi8(_mm_shuffle_epi8(table.blocks[0], types), _mm_shuffle_epi8(table.blocks[1], types), bit4);
    if constexpr (kBlocks == 2) {
      return low;
    } else {
      const __m128i high =
          _mm_blendv_epi8(_mm_shuffle_epi8(table.blocks[2], types), _mm_shuffle_epi8(table.blocks[3], types), bit4);
      return _mm_blendv_epi8(low, high, _mm_slli_epi16(types, 2));
    }
  }
}

#endif

}  // namespace espalier::derivation

// Many blocks of Philox4x32-10 at once. Four (AVX2) or two (SSE2) blocks share a register: each 64-bit lane holds a
// word of one block in its low half. The multiplication takes that half and gives both words of a product. Compilers do
// not find this: their code for the plain loop was slower than one block at a time.
#include <algorithm>

#include "engine/core/random.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace espalier::core {
namespace {

#if defined(__x86_64__)

// constants of Philox4x32 (Salmon et al. 2011, table 2 and section 4)
constexpr std::uint32_t kMultiplier0 = 0xD2511F53;
constexpr std::uint32_t kMultiplier1 = 0xCD9E8D57;
constexpr std::uint32_t kWeyl0 = 0x9E3779B9;
constexpr std::uint32_t kWeyl1 = 0xBB67AE85;
constexpr int kRounds = 10;

std::int64_t lane(std::uint64_t value) {
  return static_cast<std::int64_t>(value);
}

/// The words of four counters, or of the blocks that are made of them.
struct FourBlocks {
  __m256i word0;
  __m256i word1;
  __m256i word2;
  __m256i word3;
};

/// Makes the blocks of eight counters in their place. Two registers for each word: neither waits for the other.
[[gnu::target("avx2")]] inline void makeBlocks(std::array<std::uint32_t, 2> key, FourBlocks& a, FourBlocks& b) {
  const __m256i multiplier0 = _mm256_set1_epi64x(kMultiplier0);
  const __m256i multiplier1 = _mm256_set1_epi64x(kMultiplier1);
  for (int round = 0; round < kRounds; ++round) {
    const __m256i key0 = _mm256_set1_epi64x(key[0]);
    const __m256i key1 = _mm256_set1_epi64x(key[1]);
    const __m256i productA0 = _mm256_mul_epu32(a.word0, multiplier0);
    const __m256i productA1 = _mm256_mul_epu32(a.word2, multiplier1);
    const __m256i productB0 = _mm256_mul_epu32(b.word0, multiplier0);
    const __m256i productB1 = _mm256_mul_epu32(b.word2, multiplier1);
    a.word0 = _mm256_xor_si256(_mm256_srli_epi64(productA1, 32), _mm256_xor_si256(a.word1, key0));
    a.word2 = _mm256_xor_si256(_mm256_srli_epi64(productA0, 32), _mm256_xor_si256(a.word3, key1));
    b.word0 = _mm256_xor_si256(_mm256_srli_epi64(productB1, 32), _mm256_xor_si256(b.word1, key0));
    b.word2 = _mm256_xor_si256(_mm256_srli_epi64(productB0, 32), _mm256_xor_si256(b.word3, key1));
    a.word1 = productA1;
    a.word3 = productA0;
    b.word1 = productB1;
    b.word3 = productB0;
    key[0] += kWeyl0;
    key[1] += kWeyl1;
  }
}

/// Writes four blocks as 16 words: two words to a lane, then the lanes of a block side by side.
[[gnu::target("avx2")]] inline void storeBlocks(const FourBlocks& made, std::uint32_t* words) {
  const __m256i low = _mm256_set1_epi64x(0xFFFFFFFF);
  const __m256i words01 = _mm256_or_si256(_mm256_and_si256(made.word0, low), _mm256_slli_epi64(made.word1, 32));
  const __m256i words23 = _mm256_or_si256(_mm256_and_si256(made.word2, low), _mm256_slli_epi64(made.word3, 32));
  const __m256i even = _mm256_unpacklo_epi64(words01, words23);  // blocks 0 and 2
  const __m256i odd = _mm256_unpackhi_epi64(words01, words23);   // blocks 1 and 3
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(words), _mm256_permute2x128_si256(even, odd, 0x20));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(words + 8), _mm256_permute2x128_si256(even, odd, 0x31));
}

/// The eight blocks of DrawDomain::Selection from index `first` on, as 32 words.
[[gnu::target("avx2")]] void makeEightBlocks(const std::array<std::uint32_t, 2>& key, std::uint32_t step,
                                             std::uint64_t first, std::uint32_t* words) {
  const __m256i steps = _mm256_set1_epi64x(step);
  const __m256i zero = _mm256_setzero_si256();
  const __m256i indices = _mm256_add_epi64(_mm256_set1_epi64x(lane(first)), _mm256_setr_epi64x(0, 1, 2, 3));
  const __m256i next = _mm256_add_epi64(indices, _mm256_set1_epi64x(4));
  FourBlocks a{indices, _mm256_srli_epi64(indices, 32), steps, zero};
  FourBlocks b{next, _mm256_srli_epi64(next, 32), steps, zero};
  makeBlocks(key, a, b);
  storeBlocks(a, words);
  storeBlocks(b, words + 16);
}

/// Eight blocks of the counters (indices[i], step, last[i]), as 32 words.
[[gnu::target("avx2")]] void makeEightBlocks(const std::array<std::uint32_t, 2>& key, std::uint32_t step,
                                             const std::uint64_t* indices, const std::uint32_t* last,
                                             std::uint32_t* words) {
  const auto load = [&](std::size_t from) __attribute__((target("avx2"))) {
    const __m256i index = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(indices + from));
    return FourBlocks{index, _mm256_srli_epi64(index, 32), _mm256_set1_epi64x(step),
                      _mm256_cvtepu32_epi64(_mm_loadu_si128(reinterpret_cast<const __m128i*>(last + from)))};
  };
  FourBlocks a = load(0);
  FourBlocks b = load(4);
  makeBlocks(key, a, b);
  storeBlocks(a, words);
  storeBlocks(b, words + 16);
}

/// Two blocks from `first` on, as 8 words.
void makeTwoBlocks(std::array<std::uint32_t, 2> key, std::uint32_t step, std::uint64_t first, std::uint32_t* words) {
  const __m128i multiplier0 = _mm_set1_epi64x(kMultiplier0);
  const __m128i multiplier1 = _mm_set1_epi64x(kMultiplier1);
  __m128i c0 = _mm_set_epi64x(lane(first + 1), lane(first));
  __m128i c1 = _mm_srli_epi64(c0, 32);
  __m128i c2 = _mm_set1_epi64x(step);
  __m128i c3 = _mm_setzero_si128();
  for (int round = 0; round < kRounds; ++round) {
    const __m128i product0 = _mm_mul_epu32(c0, multiplier0);
    const __m128i product1 = _mm_mul_epu32(c2, multiplier1);
    c0 = _mm_xor_si128(_mm_srli_epi64(product1, 32), _mm_xor_si128(c1, _mm_set1_epi64x(key[0])));
    c2 = _mm_xor_si128(_mm_srli_epi64(product0, 32), _mm_xor_si128(c3, _mm_set1_epi64x(key[1])));
    c1 = product1;
    c3 = product0;
    key[0] += kWeyl0;
    key[1] += kWeyl1;
  }
  const __m128i low = _mm_set1_epi64x(0xFFFFFFFF);
  const __m128i c01 = _mm_or_si128(_mm_and_si128(c0, low), _mm_slli_epi64(c1, 32));
  const __m128i c23 = _mm_or_si128(_mm_and_si128(c2, low), _mm_slli_epi64(c3, 32));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(words), _mm_unpacklo_epi64(c01, c23));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(words + 4), _mm_unpackhi_epi64(c01, c23));
}

#endif

}  // namespace

void CounterRandom::selectionWords(std::uint32_t step, std::uint64_t firstBlock, std::size_t blockCount,
                                   std::uint32_t* words) const {
  std::size_t made = 0;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) {
    for (; made + 8 <= blockCount; made += 8) {
      makeEightBlocks(key_, step, firstBlock + made, words + 4 * made);
    }
  }
  for (; made + 2 <= blockCount; made += 2) {
    makeTwoBlocks(key_, step, firstBlock + made, words + 4 * made);
  }
#endif
  for (; made < blockCount; ++made) {
    const std::array<std::uint32_t, 4> last = block(DrawDomain::Selection, step, firstBlock + made, 0);
    for (std::size_t i = 0; i < 4; ++i) {
      words[4 * made + i] = last[i];
    }
  }
}

void CounterRandom::uniformPairs(DrawDomain domain, std::uint32_t step, std::size_t count, const std::uint64_t* indices,
                                 const std::uint32_t* pairs, double* numbers) const {
  std::size_t made = 0;
  const auto write = [&](const std::array<std::uint32_t, 4>& words) {
    const std::array<double, 2> pair = pairOf(words);
    std::copy(pair.begin(), pair.end(), numbers + 2 * made);
    ++made;
  };
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) {
    while (made + 8 <= count) {
      std::array<std::uint32_t, 8> last;
      for (std::size_t i = 0; i < last.size(); ++i) {
        last[i] = lastWord(domain, pairs[made + i]);
      }
      std::array<std::uint32_t, 32> words;
      makeEightBlocks(key_, step, indices + made, last.data(), words.data());
      for (std::size_t i = 0; i < words.size(); i += 4) {
        write({words[i], words[i + 1], words[i + 2], words[i + 3]});
      }
    }
  }
#endif
  while (made < count) {
    write(block(domain, step, indices[made], pairs[made]));
  }
}

}  // namespace espalier::core

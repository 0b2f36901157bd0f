#include "engine/derivation/module_finder.h"

#include <algorithm>
#include <utility>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace espalier::derivation {
namespace {

constexpr std::uint16_t kLargestVectorArity = 15;  // the parameters of 16 modules are counted in a byte
constexpr std::uint8_t kAllBits = 0xFF;

bool hasVectors() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi") != 0 &&
         __builtin_cpu_supports("popcnt") != 0;
#else
  return false;
#endif
}

}  // namespace

#if defined(__x86_64__)

// both on every function below: what is inlined must know the same instructions
#define ESPALIER_VECTOR [[gnu::target("avx2,bmi,popcnt"), gnu::always_inline]] static inline

/// The vector loop of ModuleFinder::find.
struct VectorFinder {
  static constexpr std::uint32_t kAtOnce = 16;

  /// A table of 16 * kBlocks bytes in registers.
  template <std::uint32_t kBlocks>
  struct Table {
    __m128i blocks[kBlocks];
  };

  template <std::uint32_t kBlocks>
  ESPALIER_VECTOR Table<kBlocks> load(const std::uint8_t* bytes) {
    Table<kBlocks> table;
    for (std::uint32_t i = 0; i < kBlocks; ++i) {
      table.blocks[i] = _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes + std::size_t{16} * i));
    }
    return table;
  }

  /// The bytes of 16 types, each less than 16 * kBlocks.
  template <std::uint32_t kBlocks>
  ESPALIER_VECTOR __m128i lookUp(const Table<kBlocks>& table, __m128i types) {
    if constexpr (kBlocks == 1) {
      return _mm_shuffle_epi8(table.blocks[0], types);
    } else {
      // a blend is decided by the top bit of each byte
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

  ESPALIER_VECTOR __m128i loadTypes(const core::ModuleTypeId* types) {
    return _mm_packus_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(types)),
                            _mm_loadu_si128(reinterpret_cast<const __m128i*>(types + 8)));
  }

  /// From module `begin` to the last whole sixteen before `end`; returns where it stopped.
  template <std::uint32_t kBlocks, bool kLooksAround>
  [[gnu::target("avx2,bmi,popcnt")]] static std::uint32_t run(const ModuleFinder::ByteTables& tables,
                                                              const core::ModuleTypeId* types, std::uint32_t begin,
                                                              std::uint32_t end, const ModuleFinder::Target& target,
                                                              ModuleFinder::Count& count) {
    const Table<kBlocks> own = load<kBlocks>(tables.own.data());
    const Table<kBlocks> before = load<kBlocks>(tables.before.data());
    const Table<kBlocks> behind = load<kBlocks>(tables.behind.data());
    const Table<kBlocks> arity = load<kBlocks>(tables.arity.data());
    const __m128i zero = _mm_setzero_si128();
    std::uint32_t* modules = target.modules + count.found;
    std::uint32_t* offsets = target.offsets + count.found;
    std::uint8_t* bits = target.bits + count.found;
    std::uint32_t offset = count.parameters;
    alignas(16) std::array<std::uint8_t, 2 * kAtOnce> found{};
    alignas(16) std::array<std::uint8_t, 2 * kAtOnce> sums{};
    std::uint32_t module = begin;
    for (; module + kAtOnce <= end; module += kAtOnce) {
      const __m128i type = loadTypes(types + module);
      __m128i common = lookUp(own, type);
      if constexpr (kLooksAround) {
        common = _mm_and_si128(common, lookUp(before, loadTypes(types + module - 1)));
        common = _mm_and_si128(common, lookUp(behind, loadTypes(types + module + 1)));
      }
      // running sum of the parameters
      const __m128i counts = lookUp(arity, type);
      __m128i sum = _mm_add_epi8(counts, _mm_slli_si128(counts, 1));
      sum = _mm_add_epi8(sum, _mm_slli_si128(sum, 2));
      sum = _mm_add_epi8(sum, _mm_slli_si128(sum, 4));
      sum = _mm_add_epi8(sum, _mm_slli_si128(sum, 8));
      auto mask = ~static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_cmpeq_epi8(common, zero))) & 0xFFFFU;
      if (mask != 0) {
        _mm_store_si128(reinterpret_cast<__m128i*>(found.data()), common);
        _mm_store_si128(reinterpret_cast<__m128i*>(sums.data()), _mm_sub_epi8(sum, counts));
        const auto foundCount = static_cast<std::uint32_t>(_mm_popcnt_u32(mask));
        // always four, so that few cost no branch; without a bit left the place is 32, of which nothing is kept
        const auto writeFour = [&](std::uint32_t first) __attribute__((target("avx2,bmi,popcnt"), always_inline)) {
          for (std::uint32_t k = first; k < first + 4; ++k) {
            const std::uint32_t place = _tzcnt_u32(mask) & 31U;
            modules[k] = module + place;
            offsets[k] = offset + sums[place];
            bits[k] = found[place];
            mask &= mask - 1;
          }
        };
        writeFour(0);
        if (foundCount > 4) {
          writeFour(4);
          if (foundCount > 8) {
            writeFour(8);
            writeFour(12);
          }
        }
        modules += foundCount;
        offsets += foundCount;
        bits += foundCount;
      }
      offset += static_cast<std::uint32_t>(_mm_extract_epi8(sum, 15));
    }
    count.found = static_cast<std::size_t>(modules - target.modules);
    count.parameters = offset;
    return module;
  }

  template <std::uint32_t kBlocks>
  static std::uint32_t run(const ModuleFinder::ByteTables& tables, bool looksAround, const core::ModuleTypeId* types,
                           std::uint32_t begin, std::uint32_t end, const ModuleFinder::Target& target,
                           ModuleFinder::Count& count) {
    return looksAround ? run<kBlocks, true>(tables, types, begin, end, target, count)
                       : run<kBlocks, false>(tables, types, begin, end, target, count);
  }
};

#undef ESPALIER_VECTOR

#endif

ModuleFinder::ModuleFinder(std::span<const std::uint16_t> arity, Marks marks)
    : arity_(arity), marks_(std::move(marks)), looksAround_(!marks_.before.empty()) {
  if (arity.size() > kMostTypes ||
      std::any_of(arity.begin(), arity.end(), [](std::uint16_t count) { return count > kLargestVectorArity; }) ||
      !hasVectors()) {
    return;
  }
  blockCount_ = arity.size() <= 16 ? 1 : (arity.size() <= 32 ? 2 : 4);
  for (std::size_t type = 0; type < arity.size(); ++type) {
    tables_.own[type] = marks_.own[type];
    tables_.before[type] = looksAround_ ? marks_.before[type] : kAllBits;
    tables_.behind[type] = looksAround_ ? marks_.behind[type] : kAllBits;
    tables_.arity[type] = static_cast<std::uint8_t>(arity[type]);
  }
}

void ModuleFinder::findOne(const core::ModuleTypeId* types, std::uint32_t module, bool hasBefore, bool hasBehind,
                           const Target& target, Count& count) const {
  std::uint8_t bits = marks_.own[types[module]];
  if (hasBefore) {
    bits &= marks_.before[types[static_cast<std::ptrdiff_t>(module) - 1]];
  }
  if (hasBehind) {
    bits &= marks_.behind[types[module + std::size_t{1}]];
  }
  target.modules[count.found] = module;
  target.offsets[count.found] = count.parameters;
  target.bits[count.found] = bits;
  count.found += bits != 0 ? 1 : 0;
  count.parameters += arity_[types[module]];
}

void ModuleFinder::findAll(const core::ModuleTypeId* types, std::uint32_t begin, std::uint32_t end,
                           const Target& target, Count& count) const {
  // what is written may be anything to the compiler, so that members would be read again and again
  const Target to = target;
  const std::uint16_t* arity = arity_.data();
  const std::uint8_t* own = marks_.own.data();
  std::size_t found = count.found;
  std::uint32_t parameters = count.parameters;
  const auto add = [&](std::uint32_t module, std::uint8_t bits) {
    to.modules[found] = module;
    to.offsets[found] = parameters;
    to.bits[found] = bits;
    found += bits != 0 ? 1 : 0;
    parameters += arity[types[module]];
  };
  if (looksAround_) {
    const std::uint8_t* before = marks_.before.data();
    const std::uint8_t* behind = marks_.behind.data();
    for (std::uint32_t module = begin; module < end; ++module) {
      add(module,
          static_cast<std::uint8_t>(own[types[module]] & before[types[static_cast<std::ptrdiff_t>(module) - 1]] &
                                    behind[types[module + std::size_t{1}]]));
    }
  } else {
    for (std::uint32_t module = begin; module < end; ++module) {
      add(module, own[types[module]]);
    }
  }
  count = {found, parameters};
}

ModuleFinder::Count ModuleFinder::findSlowly(const core::ModuleTypeId* types, std::uint32_t count, bool hasBefore,
                                             bool hasBehind, const Target& target) const {
  Count result;
  if (count == 0) {
    return result;
  }
  if (!looksAround_) {
    findAll(types, 0, count, target, result);
    return result;
  }
  // the ends, which may lack a neighbour, apart
  findOne(types, 0, hasBefore, hasBehind || count > 1, target, result);
  if (count > 1) {
    findAll(types, 1, count - 1, target, result);
    findOne(types, count - 1, true, hasBehind, target, result);
  }
  return result;
}

ModuleFinder::Count ModuleFinder::find(const core::ModuleTypeId* types, std::uint32_t count, bool hasBefore,
                                       bool hasBehind, const Target& target) const {
#if defined(__x86_64__)
  if (blockCount_ != 0 && count > 0) {
    Count result;
    std::uint32_t module = 0;
    // the ends, which may lack a neighbour, apart
    const std::uint32_t end = !looksAround_ || hasBehind ? count : count - 1;
    if (looksAround_ && !hasBefore && end > 0) {
      findOne(types, 0, false, true, target, result);
      module = 1;
    }
    switch (blockCount_) {
      case 1:
        module = VectorFinder::run<1>(tables_, looksAround_, types, module, end, target, result);
        break;
      case 2:
        module = VectorFinder::run<2>(tables_, looksAround_, types, module, end, target, result);
        break;
      default:
        module = VectorFinder::run<4>(tables_, looksAround_, types, module, end, target, result);
        break;
    }
    findAll(types, module, end, target, result);
    if (end < count) {
      findOne(types, end, hasBefore || end > 0, false, target, result);
    }
    return result;
  }
#endif
  return findSlowly(types, count, hasBefore, hasBehind, target);
}

}  // namespace espalier::derivation

#include "engine/derivation/state/module_finder.h"

#include <algorithm>
#include <utility>

namespace espalier::derivation {
namespace {

constexpr std::uint16_t kLargestVectorArity = 15;  // the parameters of 16 modules are counted in a byte
constexpr std::uint8_t kAllBits = 0xFF;

}  // namespace

#if defined(__x86_64__)

/// The vector loop of ModuleFinder::find.
struct VectorFinder {
  static constexpr std::uint32_t kAtOnce = 16;

  /// From module `begin` to the last whole sixteen before `end`; returns where it stopped.
  template <std::uint32_t kBlocks, bool kLooksAround>
  [[ESPALIER_VECTOR_TARGET]] static std::uint32_t run(const ModuleFinder::ByteTables& tables,
                                                      const core::ModuleTypeId* types, std::uint32_t begin,
                                                      std::uint32_t end, const ModuleFinder::Target& target,
                                                      ModuleFinder::Count& count) {
    const ByteRegisters<kBlocks> own = loadTable<kBlocks>(tables.own);
    const ByteRegisters<kBlocks> before = loadTable<kBlocks>(tables.before);
    const ByteRegisters<kBlocks> behind = loadTable<kBlocks>(tables.behind);
    const ByteRegisters<kBlocks> arity = loadTable<kBlocks>(tables.arity);
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
        // always four, so that small numbers cost no branch; a place of 32 means no bit left, and is not kept
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

#endif

ModuleFinder::ModuleFinder(std::span<const std::uint16_t> arity, Marks marks)
    : arity_(arity), marks_(std::move(marks)), looksAround_(!marks_.before.empty()) {
  if (std::any_of(arity.begin(), arity.end(), [](std::uint16_t count) { return count > kLargestVectorArity; })) {
    return;
  }
  blockCount_ = byteTableBlocks(arity.size());
  if (blockCount_ == 0) {
    return;
  }
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
  // local pointers: the compiler would read members again after each write, which may have changed them
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
    // the first and the last module on their own: they may lack a neighbour
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

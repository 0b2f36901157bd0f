#include "engine/derivation/batch/type_sum.h"

#include <algorithm>
#include <utility>

namespace espalier::derivation {
namespace {

constexpr std::uint32_t kLargestByte = 255;

#if defined(__x86_64__)

constexpr std::uint64_t kAtOnce = 16;

/// The sum over the whole sixteens among `count` modules.
template <std::uint32_t kBlocks>
[[ESPALIER_VECTOR_TARGET]] std::uint64_t sumSixteens(const ByteTable& bytes, const core::ModuleTypeId* types,
                                                     std::uint64_t count) {
  const ByteRegisters<kBlocks> table = loadTable<kBlocks>(bytes);
  __m128i sum = _mm_setzero_si128();
  for (std::uint64_t i = 0; i + kAtOnce <= count; i += kAtOnce) {
    // sums of eight bytes each
    sum = _mm_add_epi64(sum, _mm_sad_epu8(lookUp(table, loadTypes(types + i)), _mm_setzero_si128()));
  }
  return static_cast<std::uint64_t>(_mm_extract_epi64(sum, 0)) + static_cast<std::uint64_t>(_mm_extract_epi64(sum, 1));
}

#endif

}  // namespace

TypeSum::TypeSum(std::vector<std::uint32_t> byType)
    : byType_(std::move(byType)),
      isZero_(std::all_of(byType_.begin(), byType_.end(), [](std::uint32_t number) { return number == 0; })) {
  if (std::all_of(byType_.begin(), byType_.end(), [](std::uint32_t number) { return number <= kLargestByte; })) {
    blockCount_ = byteTableBlocks(byType_.size());
  }
  for (std::size_t type = 0; blockCount_ != 0 && type < byType_.size(); ++type) {
    table_[type] = static_cast<std::uint8_t>(byType_[type]);
  }
}

std::uint64_t TypeSum::ofSlowly(const core::ModuleTypeId* types, std::uint64_t count) const {
  const std::uint32_t* byType = byType_.data();
  std::uint64_t sum = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    sum += byType[types[i]];
  }
  return sum;
}

std::uint64_t TypeSum::of(const core::ModuleTypeId* types, std::uint64_t count) const {
  if (isZero_) {
    return 0;
  }
#if defined(__x86_64__)
  if (blockCount_ != 0) {
    const std::uint64_t rest = count % kAtOnce;
    const std::uint64_t sum = blockCount_ == 1   ? sumSixteens<1>(table_, types, count)
                              : blockCount_ == 2 ? sumSixteens<2>(table_, types, count)
                                                 : sumSixteens<4>(table_, types, count);
    return sum + ofSlowly(types + (count - rest), rest);
  }
#endif
  return ofSlowly(types, count);
}

}  // namespace espalier::derivation

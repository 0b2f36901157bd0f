#include "server/stream/text_difference.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

namespace espalier::server {
namespace {

constexpr std::size_t kStretch = 16;

/// Where the base has stretches: those that begin at multiples of their length, by their bytes.
class StretchTable {
 public:
  explicit StretchTable(std::string_view base) : slots_(std::bit_ceil(2 * base.size() / kStretch + 2), kEmpty) {
    for (std::size_t at = 0; at + kStretch <= base.size(); at += kStretch) {
      std::uint64_t& slot = slots_[hash(base.data() + at) & (slots_.size() - 1)];
      if (slot == kEmpty) {
        slot = at;
      }
    }
  }

  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

  /// A place whose bytes may be those at `text`, or kEmpty.
  [[nodiscard]] std::uint64_t find(const char* text) const { return slots_[hash(text) & (slots_.size() - 1)]; }

 private:
  static std::uint64_t hash(const char* text) {
    std::uint64_t a = 0;
    std::uint64_t b = 0;
    std::memcpy(&a, text, sizeof a);
    std::memcpy(&b, text + sizeof a, sizeof b);
    a = (a ^ std::rotl(b, 31)) * 0x9E3779B97F4A7C15U;
    return a ^ (a >> 32U);
  }

  std::vector<std::uint64_t> slots_;
};

std::size_t commonLength(std::string_view a, std::string_view b) {
  const std::size_t bound = std::min(a.size(), b.size());
  std::size_t length = 0;
  // eight bytes at a time
  while (length + 8 <= bound && std::memcmp(a.data() + length, b.data() + length, 8) == 0) {
    length += 8;
  }
  while (length < bound && a[length] == b[length]) {
    ++length;
  }
  return length;
}

}  // namespace

std::vector<TextPiece> differenceOf(std::string_view base, std::string_view text) {
  std::vector<TextPiece> pieces;
  std::size_t ownBegin = 0;
  std::size_t at = 0;
  const auto take = [&](std::size_t from, std::size_t count) {
    if (ownBegin < at) {
      pieces.push_back({0, 0, text.substr(ownBegin, at - ownBegin)});
    }
    pieces.push_back({from, count, {}});
    at += count;
    ownBegin = at;
  };

  // the beginning is mostly the same
  if (const std::size_t count = commonLength(base, text); count >= kStretch) {
    take(0, count);
  }
  const StretchTable table(base);
  while (at + kStretch <= text.size()) {
    std::uint64_t from = table.find(text.data() + at);
    std::size_t count = from == StretchTable::kEmpty ? 0 : commonLength(base.substr(from), text.substr(at));
    if (count < kStretch) {
      ++at;
      continue;
    }
    // it may begin earlier
    while (from > 0 && at > ownBegin && base[from - 1] == text[at - 1]) {
      --from;
      --at;
      ++count;
    }
    take(from, count);
  }
  if (ownBegin < text.size()) {
    pieces.push_back({0, 0, text.substr(ownBegin)});
  }
  return pieces;
}

}  // namespace espalier::server

#include "engine/derivation/state/string_index.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace espalier::derivation {
namespace {

constexpr std::uint8_t kOpens = 1;
constexpr std::uint8_t kCloses = 2;
// modules whose brackets are found at once
constexpr std::uint64_t kFoundAtOnce = 1024;
// modules of two strings that are compared at once
constexpr std::size_t kComparedAtOnce = 64;
// shapes of the brackets; the other shapes are numbers of parameters
constexpr std::uint32_t kOpenShape = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kCloseShape = kOpenShape - 1;

ModuleFinder::Marks bracketMarks(const language::Program& program) {
  ModuleFinder::Marks marks;
  marks.own.assign(program.moduleTypeCount(), 0);
  for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
    const auto type = static_cast<core::ModuleTypeId>(i);
    marks.own[i] = type == program.openBranch ? kOpens : (type == program.closeBranch ? kCloses : std::uint8_t{0});
  }
  return marks;
}

}  // namespace

StringIndex::StringIndex(const language::Program& program, std::uint64_t longestShortBranch)
    : brackets_(program.arity, bracketMarks(program)),
      shape_(program.arity.begin(), program.arity.end()),
      longestShortBranch_(longestShortBranch) {
  // beyond all numbers of parameters
  shape_[program.openBranch] = kOpenShape;
  shape_[program.closeBranch] = kCloseShape;
}

bool StringIndex::isShared(std::span<const core::ModuleTypeId> before, std::span<const core::ModuleTypeId> now) const {
  if (before.size() != now.size()) {
    return false;
  }
  for (std::size_t begin = 0; begin < now.size(); begin += kComparedAtOnce) {
    const std::size_t count = std::min(kComparedAtOnce, now.size() - begin);
    if (std::memcmp(before.data() + begin, now.data() + begin, count * sizeof(core::ModuleTypeId)) == 0) {
      continue;
    }
    for (std::size_t i = begin; i < begin + count; ++i) {
      if (shape_[before[i]] != shape_[now[i]]) {
        return false;
      }
    }
  }
  return true;
}

void StringIndex::clear() {
  links_.clear();
  longLinks_.clear();
  open_.clear();
  indexed_ = 0;
  parameterOffset_ = 0;
}

template <typename OnClosed, typename OnLong>
std::uint64_t StringIndex::linkStretch(const core::ModuleTypeId* types, std::uint64_t first, std::uint64_t end,
                                       std::uint64_t offset, core::Buffer<Open>& open, OnClosed onClosed,
                                       OnLong onLong) {
  std::array<std::uint32_t, kFoundAtOnce + ModuleFinder::kSlack> modules;
  std::array<std::uint32_t, kFoundAtOnce + ModuleFinder::kSlack> offsets;
  std::array<std::uint8_t, kFoundAtOnce + ModuleFinder::kSlack> bits;
  ShortLink* const links = links_.data();
  for (std::uint64_t begin = first; begin < end; begin += kFoundAtOnce) {
    const auto count = static_cast<std::uint32_t>(std::min(kFoundAtOnce, end - begin));
    const ModuleFinder::Count found =
        brackets_.find(types + begin, count, false, false, {modules.data(), offsets.data(), bits.data()});
    // room for all modules, because all may be `[`
    std::uint64_t depth = open.size();
    open.resize(depth + found.found + 1);
    Open* const stack = open.data();
    for (std::size_t i = 0; i < found.found; ++i) {
      // the processor cannot predict the order of `[` and `]`, so one code serves both: both write the place above the
      // top, and both write two links, which for `[` are its own
      const Open here{begin + modules[i], offset + offsets[i]};
      const bool closes = bits[i] == kCloses;
      if (closes && depth == 0) [[unlikely]] {
        onClosed(here);
        continue;
      }
      stack[depth] = here;
      const Open partner = stack[depth - (closes ? 1 : 0)];
      const std::uint64_t distance = here.module - partner.module;
      const std::uint64_t parameterCount = here.parameterOffset - partner.parameterOffset;
      depth = closes ? depth - 1 : depth + 1;
      if (isLong(distance, parameterCount)) [[unlikely]] {
        onLong({partner.module, here.module, parameterCount});
        continue;
      }
      const auto shortDistance = static_cast<std::int32_t>(distance);
      const auto shortCount = static_cast<std::uint32_t>(parameterCount);
      links[here.module] = {-shortDistance, shortCount};
      links[partner.module] = {shortDistance, shortCount};
    }
    open.resize(depth);
    offset += found.parameters;
  }
  return offset;
}

void StringIndex::extend(const ModuleString& string) {
  const std::uint64_t size = string.size();
  links_.resize(size);
  parameterOffset_ = linkStretch(
      string.types().data(), indexed_, size, parameterOffset_, open_,
      [this](const Open& closed) {
        links_[closed.module] = {kNoPartner, 0};
      },
      [this](const Branch& branch) { linkLong(branch); });
  indexed_ = size;
}

void StringIndex::beginParts(std::uint64_t size) {
  clear();
  links_.resize(size);
}

void StringIndex::linkPart(const core::ModuleTypeId* types, std::uint64_t first, std::uint64_t end, OpenEnds& ends) {
  ends.closed.clear();
  ends.opened.clear();
  ends.longBranches.clear();
  static_cast<void>(linkStretch(
      types, first, end, 0, ends.opened, [&ends](const Open& closed) { ends.closed.push_back(closed); },
      [&ends](const Branch& branch) { ends.longBranches.push_back(branch); }));
}

void StringIndex::joinPart(const OpenEnds& ends, std::uint64_t parameterOffset) {
  for (const Branch& branch : ends.longBranches) {
    linkLong(branch);
  }
  for (const Open& end : ends.closed) {
    if (open_.empty()) {
      links_[end.module] = {kNoPartner, 0};
      continue;
    }
    const Open open = open_[open_.size() - 1];
    open_.resize(open_.size() - 1);
    const std::uint64_t distance = end.module - open.module;
    const std::uint64_t parameterCount = parameterOffset + end.parameterOffset - open.parameterOffset;
    if (isLong(distance, parameterCount)) {
      linkLong({open.module, end.module, parameterCount});
    } else {
      linkShort(open.module, distance, parameterCount);
    }
  }
  for (const Open& end : ends.opened.view()) {
    open_.push_back({end.module, parameterOffset + end.parameterOffset});
  }
}

void StringIndex::linkShort(std::uint64_t open, std::uint64_t distance, std::uint64_t parameterCount) {
  const auto shortDistance = static_cast<std::int32_t>(distance);
  const auto shortCount = static_cast<std::uint32_t>(parameterCount);
  links_[open + distance] = {-shortDistance, shortCount};
  links_[open] = {shortDistance, shortCount};
}

void StringIndex::linkLong(const Branch& branch) {
  links_[branch.open] = {kIsLong, 0};
  links_[branch.close] = {kIsLong, 0};
  longLinks_[branch.close] = {branch.open, branch.parameterCount};
  longLinks_[branch.open] = {branch.close, branch.parameterCount};
}

}  // namespace espalier::derivation

#include "engine/derivation/string_index.h"

namespace espalier::derivation {

void StringIndex::clear() {
  links_.clear();
  longLinks_.clear();
  open_.clear();
  indexed_ = 0;
  parameterOffset_ = 0;
}

void StringIndex::extend(const language::Program& program, const ModuleString& string) {
  const std::uint64_t size = string.size();
  links_.resize(size);
  const core::ModuleTypeId* types = string.types().data();
  const std::uint16_t* arity = program.arity.data();
  ShortLink* links = links_.data();
  std::uint64_t offset = parameterOffset_;
  for (std::uint64_t i = indexed_; i < size; ++i) {
    const core::ModuleTypeId type = types[i];
    if (type == program.openBranch) {
      links[i] = {kNoPartner, 0};
      open_.push_back({i, offset});
    } else if (type == program.closeBranch) {
      if (open_.empty()) {
        links[i] = {kNoPartner, 0};
      } else {
        const Open open = open_.back();
        open_.pop_back();
        if (!linkShort(open, i, offset)) {
          linkLong({open.module, i, offset - open.parameterOffset});
        }
      }
    }
    offset += arity[type];
  }
  indexed_ = size;
  parameterOffset_ = offset;
}

void StringIndex::beginParts(std::uint64_t size) {
  clear();
  links_.resize(size);
}

void StringIndex::linkPart(const language::Program& program, const core::ModuleTypeId* types, std::uint64_t first,
                           std::uint64_t end, OpenEnds& ends) {
  ends.closed.clear();
  ends.opened.clear();
  ends.longBranches.clear();
  const std::uint16_t* arity = program.arity.data();
  std::uint64_t offset = 0;
  for (std::uint64_t i = first; i < end; ++i) {
    const core::ModuleTypeId type = types[i];
    if (type == program.openBranch) {
      ends.opened.push_back({i, offset});
    } else if (type == program.closeBranch) {
      if (ends.opened.empty()) {
        ends.closed.push_back({i, offset});
      } else {
        const Open open = ends.opened.back();
        ends.opened.pop_back();
        if (!linkShort(open, i, offset)) {
          ends.longBranches.push_back({open.module, i, offset - open.parameterOffset});
        }
      }
    }
    offset += arity[type];
  }
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
    const Open open = open_.back();
    open_.pop_back();
    const std::uint64_t offset = parameterOffset + end.parameterOffset;
    if (!linkShort(open, end.module, offset)) {
      linkLong({open.module, end.module, offset - open.parameterOffset});
    }
  }
  for (const Open& end : ends.opened) {
    links_[end.module] = {kNoPartner, 0};
    open_.push_back({end.module, parameterOffset + end.parameterOffset});
  }
}

bool StringIndex::linkShort(const Open& open, std::uint64_t close, std::uint64_t parameterOffset) {
  const std::uint64_t distance = close - open.module;
  const std::uint64_t count = parameterOffset - open.parameterOffset;
  if (distance > longestShortBranch_ || count > longestShortBranch_) [[unlikely]] {
    return false;
  }
  const auto shortDistance = static_cast<std::int32_t>(distance);
  links_[close] = {-shortDistance, static_cast<std::uint32_t>(count)};
  links_[open.module] = {shortDistance, static_cast<std::uint32_t>(count)};
  return true;
}

void StringIndex::linkLong(const Branch& branch) {
  links_[branch.open] = {kIsLong, 0};
  links_[branch.close] = {kIsLong, 0};
  longLinks_[branch.close] = {branch.open, branch.parameterCount};
  longLinks_[branch.open] = {branch.close, branch.parameterCount};
}

}  // namespace espalier::derivation

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
        const std::uint64_t distance = i - open.module;
        const std::uint64_t count = offset - open.parameterOffset;
        if (distance <= longestShortBranch_ && count <= longestShortBranch_) [[likely]] {
          const auto shortDistance = static_cast<std::int32_t>(distance);
          links[i] = {-shortDistance, static_cast<std::uint32_t>(count)};
          links[open.module] = {shortDistance, static_cast<std::uint32_t>(count)};
        } else {
          links[i] = {kIsLong, 0};
          links[open.module] = {kIsLong, 0};
          longLinks_[i] = {open.module, count};
          longLinks_[open.module] = {i, count};
        }
      }
    }
    offset += arity[type];
  }
  indexed_ = size;
  parameterOffset_ = offset;
}

}  // namespace espalier::derivation

#include "engine/derivation/string_index.h"

#include "engine/core/check.h"

namespace espalier::derivation {

void StringIndex::clear() {
  links_.clear();
  open_.clear();
  indexed_ = 0;
  parameterOffset_ = 0;
}

void StringIndex::extend(const language::Program& program, const ModuleString& string) {
  const std::uint64_t size = string.size();
  ESPALIER_CHECK(size <= kMaximumModules);
  links_.resize(size);
  const core::ModuleTypeId* types = string.types().data();
  const std::uint16_t* arity = program.arity.data();
  Link* links = links_.data();
  std::uint64_t offset = parameterOffset_;
  for (std::uint64_t i = indexed_; i < size; ++i) {
    const core::ModuleTypeId type = types[i];
    if (type == program.openBranch) {
      links[i] = {kNone, 0};
      open_.push_back({static_cast<std::uint32_t>(i), offset});
    } else if (type == program.closeBranch) {
      if (open_.empty()) {
        links[i] = {kNone, 0};
      } else {
        const Open open = open_.back();
        open_.pop_back();
        const auto count = static_cast<std::uint32_t>(offset - open.parameterOffset);
        links[i] = {open.module, count};
        links[open.module] = {static_cast<std::uint32_t>(i), count};
      }
    }
    offset += arity[type];
  }
  indexed_ = size;
  parameterOffset_ = offset;
}

}  // namespace espalier::derivation

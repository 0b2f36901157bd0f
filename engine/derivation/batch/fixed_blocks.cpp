#include "engine/derivation/batch/fixed_blocks.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace espalier::derivation {

using core::ModuleTypeId;

FixedBlocks::FixedBlocks(const language::Program& program, const ProductionPlan& plan) {
  const std::size_t typeCount = program.moduleTypeCount();
  if (typeCount == 0 || typeCount > kMostTypes) {
    return;
  }
  for (std::size_t i = 0; i < typeCount; ++i) {
    const TypePlan& type = plan[static_cast<ModuleTypeId>(i)];
    if (type.kind != TypePlan::Kind::Fixed || type.arity != 0) {
      return;
    }
  }
  plans_ = plan.plans();
  successors_ = plan.types();
  typeBits_ = static_cast<std::uint32_t>(std::bit_width(typeCount - 1));
  pairs_.resize(std::size_t{1} << (2 * typeBits_));
  lengths_.resize(pairs_.size());
  for (std::size_t first = 0; first < typeCount; ++first) {
    for (std::size_t second = 0; second < typeCount; ++second) {
      const std::size_t pair = first << typeBits_ | second;
      for (const std::size_t module : {first, second}) {
        const TypePlan& type = plan[static_cast<ModuleTypeId>(module)];
        const std::uint32_t length = lengths_[pair];
        lengths_[pair] += type.length;
        if (lengths_[pair] <= kPairTypes) {
          std::copy_n(plan.types() + type.firstType, type.length, pairs_[pair].types + length);
        }
      }
    }
  }
}

ModuleTypeId* FixedBlocks::writeOne(ModuleTypeId module, ModuleTypeId* target) const {
  const TypePlan& type = plans_[module];
  return std::copy_n(successors_ + type.firstType, type.length, target);
}

ModuleTypeId* FixedBlocks::write(const ModuleTypeId* modules, std::uint64_t count, ModuleTypeId* target,
                                 const ModuleTypeId* limit) const {
  const Pair* const pairs = pairs_.data();
  const std::uint32_t* const lengths = lengths_.data();
  const std::uint32_t typeBits = typeBits_;
  std::uint64_t i = 0;
  for (; i + 2 <= count && limit - target >= static_cast<std::ptrdiff_t>(kPairTypes); i += 2) {
    const std::size_t pair = std::size_t{modules[i]} << typeBits | modules[i + 1];
    if (lengths[pair] > kPairTypes) [[unlikely]] {
      target = writeOne(modules[i + 1], writeOne(modules[i], target));
      continue;
    }
    std::memcpy(target, pairs[pair].types, sizeof(Pair));
    target += lengths[pair];
  }
  for (; i < count; ++i) {
    target = writeOne(modules[i], target);
  }
  return target;
}

}  // namespace espalier::derivation

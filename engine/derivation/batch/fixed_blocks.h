#pragma once

#include <cstdint>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/derivation/matching/production_plan.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Writes the new modules of a model without parameters in which every module type always becomes the same block. It
/// takes two modules at a time, by a table of pairs, because the lookup and the store cost more than the modules in a
/// block.
class FixedBlocks {
 public:
  /// Models with more types have no table.
  static constexpr std::size_t kMostTypes = 32;
  /// Modules that are written for every pair, however many of them count.
  static constexpr std::size_t kPairTypes = 32;

  /// No table.
  FixedBlocks() = default;
  /// A table when all types of the Program are TypePlan::Kind::Fixed, without parameters, and few enough. `plan` must
  /// outlive the object.
  FixedBlocks(const language::Program& program, const ProductionPlan& plan);

  [[nodiscard]] bool hasTable() const { return !pairs_.empty(); }
  /// Writes the blocks of `count` modules from `modules` on to `target`, and returns their end. May write further, up
  /// to `limit`. Only with a table, and with room for all blocks.
  core::ModuleTypeId* write(const core::ModuleTypeId* modules, std::uint64_t count, core::ModuleTypeId* target,
                            const core::ModuleTypeId* limit) const;

 private:
  /// By pair: the blocks of both modules, as far as they fit.
  struct alignas(64) Pair {
    core::ModuleTypeId types[kPairTypes];
  };

  core::ModuleTypeId* writeOne(core::ModuleTypeId module, core::ModuleTypeId* target) const;

  const TypePlan* plans_ = nullptr;                 // of the ProductionPlan
  const core::ModuleTypeId* successors_ = nullptr;  // the same
  std::uint32_t typeBits_ = 0;                      // a pair is `first << typeBits | second`
  std::vector<Pair> pairs_;                         // none: no table
  std::vector<std::uint32_t> lengths_;              // by pair: the modules that count
};

}  // namespace espalier::derivation

#pragma once

#include <cstdint>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/derivation/matching/production_plan.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Writes what modules become where every module becomes the same block each time and none has parameters: two modules
/// at a time by a table of pairs, because finding the block of a module and storing it cost more than the modules that
/// it holds.
class FixedBlocks {
 public:
  /// Models of more types have no table.
  static constexpr std::size_t kMostTypes = 32;
  /// Modules of a pair's blocks that are written without asking how many count.
  static constexpr std::size_t kPairTypes = 32;

  /// No table.
  FixedBlocks() = default;
  /// A table when all types of the Program are TypePlan::Kind::Fixed, without parameters, and few enough. `plan` must
  /// outlive the object.
  FixedBlocks(const language::Program& program, const ProductionPlan& plan);

  [[nodiscard]] bool hasTable() const { return !pairs_.empty(); }
  /// Writes what `count` modules from `modules` on become to `target` and returns where that ends. Nothing is written
  /// at `limit` or behind, but up to there more than counts. Only with a table, and where all that counts has room.
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

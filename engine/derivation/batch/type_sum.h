#pragma once

#include <cstdint>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/derivation/state/byte_tables.h"

namespace espalier::derivation {

/// Adds up a number by module type over a stretch of a string: the parameters of the modules, or the modules that they
/// become. It takes sixteen modules at a time where the processor has AVX2, the model has at most 64 module types, and
/// no number is above 255.
class TypeSum {
 public:
  explicit TypeSum(std::vector<std::uint32_t> byType);
  /// The sum over `count` modules from `types` on.
  [[nodiscard]] std::uint64_t of(const core::ModuleTypeId* types, std::uint64_t count) const;
  /// The same without vector instructions.
  [[nodiscard]] std::uint64_t ofSlowly(const core::ModuleTypeId* types, std::uint64_t count) const;

 private:
  std::vector<std::uint32_t> byType_;
  bool isZero_;
  std::uint32_t blockCount_ = 0;  // of the table in use, 1, 2 or 4; 0: no vector instructions
  ByteTable table_{};
};

}  // namespace espalier::derivation

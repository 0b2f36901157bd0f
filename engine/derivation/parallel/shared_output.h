#pragma once

#include <cstdint>

#include "engine/derivation/parallel/output_pages.h"
#include "engine/derivation/state/module_string.h"

namespace espalier::derivation {

/// A ModuleString to whose end several threads write part by part, within the memory that it has reserved.
class SharedOutput {
 public:
  /// `string` must outlive the object and be left alone until finish().
  explicit SharedOutput(ModuleString& string);

  /// Whether strings of this length fit into the reserved memory.
  [[nodiscard]] bool holds(std::uint64_t moduleCount, std::uint64_t parameterCount) const;
  /// Returns when a part of the string can be written without page faults: modules [firstModule, endModule) and
  /// parameters likewise. Any number of threads at a time.
  void prepare(std::uint64_t firstModule, std::uint64_t endModule, std::uint64_t firstParameter,
               std::uint64_t endParameter);
  /// The raw arrays, from the string's beginning.
  [[nodiscard]] core::ModuleTypeId* types() const { return string_->typeBuffer().data(); }
  [[nodiscard]] double* parameters() const { return string_->parameterBuffer().data(); }

  /// The string has this length from now on. One thread.
  void finish(std::uint64_t moduleCount, std::uint64_t parameterCount);

 private:
  ModuleString* string_;
  OutputPages typePages_;
  OutputPages parameterPages_;
};

}  // namespace espalier::derivation

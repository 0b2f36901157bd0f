#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/derivation/state/module_string.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// For each module of a string that a step made: the module of the string before that it continues. A module that the
/// step copies continues itself. Of a successor the first module outside of its brackets that has the symbol of the
/// predecessor continues it, so F(l) --> F(1.1*l) grows older and A --> I[A]A goes on with its last A. All others are
/// new.
class ModuleOrigins {
 public:
  static constexpr std::uint64_t kNew = ~std::uint64_t{0};

  void clear() { from_.clear(); }
  /// The modules `oldBegin` to `oldEnd` of `old` have become `begin` to `end` of `made`, which come behind those of the
  /// calls before.
  void add(const language::Program& program, const ModuleString& old, std::uint64_t oldBegin, std::uint64_t oldEnd,
           const ModuleString& made, std::uint64_t begin, std::uint64_t end);
  /// The string has so many modules; those behind the last call are new.
  void complete(std::uint64_t modules) { from_.resize(modules, kNew); }

  /// By module of the new string.
  [[nodiscard]] std::span<const std::uint64_t> from() const { return from_; }

 private:
  std::vector<std::uint64_t> from_;
};

}  // namespace espalier::derivation

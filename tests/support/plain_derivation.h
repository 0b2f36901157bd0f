#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/language/program.h"

namespace espalier::test {

/// A module of the plain derivation.
struct PlainModule {
  core::ModuleTypeId type = core::kNoModuleType;
  std::vector<double> parameters;

  bool operator==(const PlainModule&) const = default;
};

using PlainString = std::vector<PlainModule>;

/// An executable specification of derivation, written for being obviously right, not for speed, and sharing nothing
/// with engine/derivation but the Program and the random numbers: pure productions with predecessors of any length,
/// contexts over brackets with ignored symbols, conditions, stochastic choice, ran, the cut symbol. No blocks,
/// variables, decomposition or sub-L-systems; Espalier's own mode only.
class PlainDerivation {
 public:
  PlainDerivation(const language::Program& program, std::uint64_t seed);

  [[nodiscard]] PlainString axiom() const;
  /// The string after step `step` (from 1), made from the one before it.
  [[nodiscard]] PlainString derive(const PlainString& old, std::uint64_t step) const;

 private:
  using Frame = std::vector<double>;
  /// The draws of ran that one module makes.
  struct Draws {
    std::uint64_t module = 0;
    std::uint32_t count = 0;
  };
  [[nodiscard]] double value(const language::Expression& expression, const Frame& frame, double step,
                             Draws& draws) const;
  [[nodiscard]] bool matchesPredecessor(const PlainString& old, std::size_t at, const language::Production& production,
                                        Frame& frame) const;
  [[nodiscard]] bool matchesLeft(const PlainString& old, std::size_t at, const language::Production& production,
                                 Frame& frame) const;
  [[nodiscard]] bool matchesRight(const PlainString& old, std::size_t behind, const language::Production& production,
                                  Frame& frame) const;
  [[nodiscard]] bool isIgnored(core::ModuleTypeId type) const;

  const language::Program* program_;
  std::uint64_t seed_;
};

}  // namespace espalier::test

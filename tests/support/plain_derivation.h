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
/// with engine/derivation but the Program and the random numbers: productions with predecessors of any length, contexts
/// over brackets with ignored symbols, conditions, blocks, variables, arrays, stochastic choice, ran, the cut symbol,
/// decomposition by modules of their own. No sub-L-systems; Espalier's own mode only.
class PlainDerivation {
 public:
  PlainDerivation(const language::Program& program, std::uint64_t seed);

  /// Runs Start. The string of step 0.
  [[nodiscard]] PlainString axiom();
  /// Runs StartEach. The string after step `step` (from 1), made from the one before it.
  [[nodiscard]] PlainString derive(const PlainString& old, std::uint64_t step);

  /// Values left by blocks: local variables of productions, variables of the L-system, elements of its arrays.
  [[nodiscard]] const std::vector<double>& statics() const { return statics_; }
  [[nodiscard]] const std::vector<double>& variables() const { return variables_; }
  [[nodiscard]] const std::vector<double>& elements() const { return elements_; }

 private:
  using Frame = std::vector<double>;
  /// The draws of ran that one module makes.
  struct Draws {
    std::uint64_t module = 0;
    std::uint32_t count = 0;
  };
  struct Match {
    const language::Production* production = nullptr;
    Frame frame;
    double weight = 1.0;
  };
  [[nodiscard]] double value(const language::Expression& expression, Frame& frame, double step, Draws& draws);
  /// Runs code; its value, if it has one.
  double run(language::CodeRange code, Frame& frame, double step, Draws& draws);
  [[nodiscard]] double& element(const language::Instruction& instruction, const std::vector<double>& subscripts);
  [[nodiscard]] std::vector<Match> matches(const PlainString& old, std::size_t at, double step, Draws& draws);
  PlainString successor(Match& match, double step, Draws& draws);
  void decompose(const PlainModule& module, std::uint32_t depth, double step, Draws& draws, PlainString& made);
  [[nodiscard]] bool matchesPredecessor(const PlainString& old, std::size_t at, const language::Production& production,
                                        Frame& frame) const;
  [[nodiscard]] bool matchesLeft(const PlainString& old, std::size_t at, const language::Production& production,
                                 Frame& frame) const;
  [[nodiscard]] bool matchesRight(const PlainString& old, std::size_t behind, const language::Production& production,
                                  Frame& frame) const;
  [[nodiscard]] bool isIgnored(core::ModuleTypeId type) const;

  const language::Program* program_;
  std::uint64_t seed_;
  std::vector<double> statics_;
  std::vector<double> variables_;
  std::vector<double> elements_;
};

}  // namespace espalier::test

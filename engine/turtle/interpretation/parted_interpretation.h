#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/turtle/interpretation/branch_parts.h"
#include "engine/turtle/interpretation/interpretation.h"

namespace espalier::turtle {

/// Environment passes with several threads (DerivationOptions::threads): the axis and its small branches first, which
/// gives the turtle's state at the start of every larger branch, then those branches at the same time, each into an
/// output of its own; the outputs are joined in the order of the string, so that the result is that of one thread, bit
/// by bit. Holds working memory only.
class PartedInterpretation {
 public:
  /// Returns false, with nothing changed, when there is no gain in it or it cannot be done: one thread, a scene or
  /// records are asked for, a short string, hardly any branches, a homomorphism, `?(id,k)`, or a failure, which the
  /// caller then meets in the order of the string.
  [[nodiscard]] bool run(const Interpretation::Subject& subject, const InterpretationOutput& output);

 private:
  /// What one branch, or the walk around the branches, gives.
  struct Part {
    QueryBatch queries;
    std::vector<std::uint64_t> queryOffsets;
    std::vector<ParameterChange> changes;
    std::vector<std::string> warnings;
    bool hasFailed = false;
    void clear();
  };

  void walkAround(const Interpretation::Subject& subject, const InterpretationOutput& output);
  void walkBranches(const Interpretation::Subject& subject, const InterpretationOutput& output, unsigned threads);
  [[nodiscard]] bool hasFailed() const;
  [[nodiscard]] bool appendChanges(const InterpretationOutput& output) const;
  void takeBack(derivation::PlantState& plantState) const;
  void join(const Interpretation::Subject& subject, const InterpretationOutput& output);

  std::vector<BranchPart> branches_;
  std::vector<Interpretation::BranchStart> starts_;  // by branch
  std::vector<Part> parts_;                          // by branch; more when an earlier pass had more branches
  Part around_;
};

}  // namespace espalier::turtle

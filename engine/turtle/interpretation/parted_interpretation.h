#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/turtle/interpretation/branch_parts.h"
#include "engine/turtle/interpretation/interpretation.h"

namespace espalier::turtle {

/// Environment passes with several threads (DerivationOptions::threads). First one thread interprets the axis and its
/// small branches, which gives the turtle's state at the start of each larger branch. Then threads interpret those
/// branches at the same time, each into its own output. The outputs are joined in the order of the string: the result
/// is bit by bit that of one thread. Holds working memory only.
class PartedInterpretation {
 public:
  /// Returns false, with nothing changed, when there is no gain or it is not possible: one thread, an output of scene
  /// or records, a short string, few branches, a homomorphism, `?(id,k)`. Also after a failure: the caller then meets
  /// it in the order of the string.
  [[nodiscard]] bool run(const Interpretation::Subject& subject, const InterpretationOutput& output);

 private:
  /// The output of one branch, or of the walk around the branches.
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

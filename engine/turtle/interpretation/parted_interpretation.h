#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/turtle/interpretation/branch_parts.h"
#include "engine/turtle/interpretation/interpretation.h"
#include "engine/turtle/interpretation/scene_assembly.h"

namespace espalier::turtle {

/// Environment passes and scenes with several threads (DerivationOptions::threads). First one thread interprets the
/// axis and its small branches, which gives the turtle's state at the start of each larger branch. Then threads
/// interpret those branches at the same time, each into its own output. The outputs are joined in the order of the
/// string: the result is bit by bit that of one thread. Holds working memory only.
class PartedInterpretation {
 public:
  /// Returns false, with nothing changed, when there is no gain or it is not possible: one thread, an output of
  /// records, a short string, few branches, `?(id,k)`; for queries any homomorphism; for scenes one that depends on
  /// more than its module or leaves brackets open, a patch, or a shape that is open where a branch begins or ends. Also
  /// after a failure, or when the model warns: the caller then meets it in the order of the string.
  [[nodiscard]] bool run(const Interpretation::Subject& subject, const InterpretationOutput& output);

 private:
  /// The output of one branch, or of the walk around the branches.
  struct Part {
    QueryBatch queries;
    std::vector<std::uint64_t> queryOffsets;
    std::vector<ParameterChange> changes;
    std::vector<std::string> warnings;
    Scene scene;
    bool hasFailed = false;
    bool isOutOfPlace = false;  // a shape is open at the end, or one from before was used
    void clear();
  };

  /// Derivations that expand modules, one for each thread; empty without homomorphism.
  using Expanders = std::vector<derivation::Derivation>;

  void clear();
  [[nodiscard]] bool findBranches(const Interpretation::Subject& subject, unsigned threads);
  [[nodiscard]] Expanders makeExpanders(const Interpretation::Subject& subject, unsigned threads);
  void walkAround(const Interpretation::Subject& subject, const InterpretationOutput& output);
  void walkBranches(const Interpretation::Subject& subject, const InterpretationOutput& output, Expanders& expanders,
                    unsigned threads, SceneAssembly* assembly);
  [[nodiscard]] bool hasFailed() const;
  [[nodiscard]] bool isOutOfPlace() const;
  [[nodiscard]] bool appendChanges(const InterpretationOutput& output) const;
  void takeBack(derivation::PlantState& plantState) const;
  void join(const Interpretation::Subject& subject, const InterpretationOutput& output);

  std::vector<BranchPart> branches_;
  std::vector<Interpretation::BranchStart> starts_;  // by branch
  std::vector<Part> parts_;                          // by branch; more when an earlier pass had more branches
  Part around_;
  std::atomic<bool> hasSpoken_ = false;  // a homomorphism warned
  bool mayDraw_ = true;                  // until something was out of place: such models go on in that way
};

}  // namespace espalier::turtle

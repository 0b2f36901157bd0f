#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/matching/production_plan.h"
#include "engine/derivation/scan/module_rewriter.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// One module after the other, each by the table of its type (ProductionPlan). Only types of the general kind cost a
/// call of the ModuleRewriter.
class PlainScan {
 public:
  /// Both must outlive the object.
  PlainScan(ScanContext& context, ModuleRewriter& rewriter);

  /// Rewrites the modules of the old string from `place` up to `end`, and moves `place` behind them. It ends further
  /// behind when a predecessor or a cut reaches over `end`.
  void run(std::uint64_t end, ScanPlace& place);

 private:
  /// Where the next module and the next parameter are written: behind the end of the output.
  struct Target {
    core::ModuleTypeId* type = nullptr;
    double* parameter = nullptr;
  };

  template <bool kDrawsEachPosition, bool kHasParameters>
  void scan(std::uint64_t end, ScanPlace& place);
  template <bool kDrawsEachPosition, bool kHasParameters>
  void scanChunk(std::uint64_t end, ScanPlace& place);
  template <bool kHasParameters>
  void writeFixed(const TypePlan& plan, const ModuleString& old, std::uint64_t offset, Target& target);
  [[nodiscard]] Target startWriting(std::uint64_t moduleCount);
  void stopWriting(const Target& target);
  /// Copies the parameters of a module into the frame, from `firstSlot` on. Slots behind them may change.
  void loadFrame(const ModuleString& old, std::uint64_t offset, std::uint64_t arity, std::uint32_t firstSlot);
  [[nodiscard]] double evaluate(const QuickValue& value);
  [[nodiscard]] const QuickRule* chooseRule(const TypePlan& plan, core::ModuleTypeId type, std::uint64_t module,
                                            double draw);
  [[nodiscard]] const QuickRule* chooseByWeights(const QuickRule* first, const QuickRule* last, std::uint64_t module,
                                                 double draw);
  /// Loads the `arity` formal parameters of the rule, and searches its contexts.
  [[nodiscard]] bool matchesContexts(const QuickRule& rule, ScanPlace place, std::uint64_t arity);
  /// Runs the block before the rule's condition, and asks the condition.
  [[nodiscard]] bool matches(const QuickRule& rule);
  /// Rewrites the modules from `place` on, up to the first that is neither fixed nor has productions with blocks or
  /// contexts, and moves `place` behind them. `draw` is that of the first module.
  void scanInFull(std::uint64_t end, double draw, ScanPlace& place);
  void rewriteInFull(const TypePlan& plan, ScanPlace place, double draw, Target& target);
  /// The same for those that need the ModuleRewriter, up to the first of another kind.
  void scanGeneral(std::uint64_t end, double draw, ScanPlace& place);
  void writeSuccessor(const QuickRule& rule, std::uint64_t module, Target& target);
  [[noreturn]] void failNonFinite(const QuickRule& rule, std::uint32_t valueIndex, double value, std::uint64_t module);

  ScanContext* context_;
  ModuleRewriter* rewriter_;
  // of the ProductionPlan; members, because as locals of the loop they cost ten instructions a module (DESIGN.md,
  // Loops)
  const TypePlan* plans_;
  const QuickRule* rules_;
  const QuickValue* values_;
  const core::ModuleTypeId* successors_;
  bool storesFloats_;                       // Rewriter::storesFloats
  bool isNearLimits_ = false;               // the modules that startWriting makes room for may exceed a limit
  bool hasParameters_ = false;              // some module type of the Program has parameters
  std::uint64_t chunkModules_ = 1;          // old modules between two looks at the limits and at `cancelled`
  std::vector<double> frame_;               // formal parameters of the module, free places, the constants of the plan
  std::vector<double> weights_;             // of the rules that match
  std::vector<const QuickRule*> matching_;  // the same rules
};

}  // namespace espalier::derivation

#pragma once

#include <cstdint>
#include <memory>

#include "engine/derivation/batch/batch_rewriter.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// Decomposes all modules of a piece of a new string level by level: each pass rewrites every module to which a
/// decomposition production applies. The ModuleRewriter goes depth first, with the same result: the productions depend
/// on their module alone (BatchPlan::ofDecomposition).
class DecompositionPasses {
 public:
  /// `context` must outlive the object. The main L-system has SystemTables::decomposition.
  explicit DecompositionPasses(ScanContext& context);

  /// Decomposes `made`. False: something warns, fails or exceeds a limit, and `made` is of no use.
  [[nodiscard]] bool run(ModuleString& made);
  /// The values that blocks have left in local variables in the last run.
  [[nodiscard]] const LastStores& stores() const { return stores_; }

 private:
  /// One pass from `made` to next_. `isChanged`: a production applies.
  bool pass(const ModuleString& made, bool& isChanged);
  void begin(const ModuleString& made);

  ScanContext* context_;
  const language::ProductionList* list_;  // in the Program
  BatchRewriter batch_;
  ModuleString next_;
  LastStores stores_;  // of all passes; the places are those of the present level
  LastStores moved_;   // the same at the places of the next level
};

}  // namespace espalier::derivation

#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/scan/module_rewriter.h"
#include "engine/derivation/scan/scan_context.h"
#include "engine/derivation/scan/sub_systems.h"

namespace espalier::derivation {

/// The scan of a model with sub-L-systems: enters and leaves calls along the string, and rewrites every module in the
/// general way by the productions of the L-system around it.
class SubSystemScan {
 public:
  /// All must outlive the object.
  SubSystemScan(ScanContext& context, ModuleRewriter& rewriter, SubSystems& calls)
      : context_(&context), rewriter_(&rewriter), calls_(&calls) {}

  /// The whole old string. Gives the plant the instances of the calls in the output.
  void run();

 private:
  /// Where the instance of a call in the new string comes from.
  struct Origin {
    bool isFresh = false;
    std::uint32_t index = 0;  // of the old instance, or the L-system of a fresh one
  };

  void rewriteNext(ScanPlace& place);
  [[nodiscard]] StringPart findCut(const ScanPlace& place);
  void addFreshCalls(std::uint64_t firstModule, std::uint64_t firstParameter);
  void makeInstances();

  ScanContext* context_;
  ModuleRewriter* rewriter_;
  SubSystems* calls_;
  std::uint32_t nextCall_ = 1;        // instance of the next call in the old string
  std::vector<Origin> origins_;       // of the calls in the output, in order
  std::vector<Origin> movedOrigins_;  // of the calls in parts that `%(p)` moves to the end, in order
};

}  // namespace espalier::derivation

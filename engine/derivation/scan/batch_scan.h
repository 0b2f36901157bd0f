#pragma once

#include <cstdint>
#include <memory>

#include "engine/derivation/batch/batch_rewriter.h"
#include "engine/derivation/scan/decomposition_passes.h"
#include "engine/derivation/scan/plain_scan.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// A chunk of modules at a time (BatchRewriter). A chunk ends before a module that batches cannot do; such modules, and
/// the modules between them where they stand close together, are left to the PlainScan.
class BatchScan {
 public:
  /// Both must outlive the object.
  BatchScan(ScanContext& context, PlainScan& plain) : context_(&context), plain_(&plain) {}

  /// Whether batches can do something for this string and gain more than their set-up costs.
  [[nodiscard]] bool isWorthwhile(const ModuleString& old) const;
  /// Does what PlainScan::run does.
  void run(std::uint64_t end, ScanPlace& place);

 private:
  [[nodiscard]] bool append(const BatchRewriter::Outcome& outcome);
  [[nodiscard]] bool appendDecomposed(const BatchRewriter::Outcome& outcome);

  ScanContext* context_;
  PlainScan* plain_;
  std::unique_ptr<BatchRewriter> batch_;                // made when a string is long enough to use it
  std::unique_ptr<DecompositionPasses> decomposition_;  // the same, where batches decompose
  ModuleString made_;                                   // by the productions, before the decomposition
  std::uint64_t plainModules_ = 0;    // left to the PlainScan before the next batch, over the ends of steps
  std::uint64_t generalStretch_ = 1;  // modules that are left to it behind a module that batches cannot do
};

/// The data of the context that a BatchRewriter needs at this place of the step.
[[nodiscard]] BatchRewriter::Step batchStep(const ScanContext& context);

}  // namespace espalier::derivation

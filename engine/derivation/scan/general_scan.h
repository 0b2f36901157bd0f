#pragma once

#include "engine/derivation/scan/module_rewriter.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// Every module in the general way, so that the record of one module holds every decision (Derivation::deriveRecorded).
class RecordedScan {
 public:
  /// Both must outlive the object.
  RecordedScan(ScanContext& context, ModuleRewriter& rewriter) : context_(&context), rewriter_(&rewriter) {}

  /// The whole old string.
  void run();

 private:
  ScanContext* context_;
  ModuleRewriter* rewriter_;
};

}  // namespace espalier::derivation

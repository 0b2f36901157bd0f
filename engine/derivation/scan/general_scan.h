#pragma once

#include "engine/derivation/scan/module_rewriter.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// Every module in the general way, so that the Rewriter sees every decision: for the record of one module
/// (Derivation::deriveRecorded), and for the counts of productions.
class GeneralScan {
 public:
  /// Both must outlive the object.
  GeneralScan(ScanContext& context, ModuleRewriter& rewriter) : context_(&context), rewriter_(&rewriter) {}

  /// The whole old string.
  void run();

 private:
  ScanContext* context_;
  ModuleRewriter* rewriter_;
};

}  // namespace espalier::derivation

#pragma once

#include "engine/derivation/matching/produced_pieces.h"
#include "engine/derivation/scan/module_rewriter.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// The string from right to left, for models with `>>`, which looks at what was produced to the right. Every module in
/// the general way.
class BackwardScan {
 public:
  /// Both must outlive the object.
  BackwardScan(ScanContext& context, ModuleRewriter& rewriter)
      : context_(&context), rewriter_(&rewriter), pieces_(context.program) {}

  /// The string produced so far, for the context's Rewriter.
  [[nodiscard]] ProducedPieces& pieces() { return pieces_; }
  /// The whole old string.
  void run();

 private:
  ScanContext* context_;
  ModuleRewriter* rewriter_;
  ProducedPieces pieces_;  // of the step
};

}  // namespace espalier::derivation

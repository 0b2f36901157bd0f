#pragma once

#include "engine/derivation/scan/module_rewriter.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// Every module in the general way, so that the Rewriter sees every decision: for the record of one module
/// (Derivation::deriveRecorded), for the counts of productions, and for the origins
/// of modules. Unchanged modules are noted one by one.
class GeneralScan {
 public:
  /// Both must outlive the object.
  GeneralScan(ScanContext& context, ModuleRewriter& rewriter) : context_(&context), rewriter_(&rewriter) {}

  /// The whole old string.
  void run();

 private:
  /// Whether the module at `begin`, whose rewriting ended at `end`, has become itself: a module at `module` of the
  /// output with equal parameters, which begin at `parameter`.
  [[nodiscard]] bool isAsItWas(const ScanPlace& begin, const ScanPlace& end, std::uint64_t module,
                               std::uint64_t parameter) const;
  /// Notes a run of modules that are as they were, when it is worth it.
  void note(const KeptModules& kept);

  ScanContext* context_;
  ModuleRewriter* rewriter_;
};

}  // namespace espalier::derivation

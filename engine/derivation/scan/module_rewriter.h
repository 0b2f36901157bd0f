#pragma once

#include <cstdint>

#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// Rewrites one module of the old string in the general way: by a production, else by a decomposition, else as a cut
/// symbol, else as a copy. The scans call it for every module that their shortcuts cannot do.
class ModuleRewriter {
 public:
  /// The effect of the step on the module.
  enum class Fate : std::uint8_t { Rewritten, Copied, Cut };
  struct Outcome {
    std::uint64_t modules = 1;  // of the old string consumed
    std::uint64_t parameters = 0;
    Fate fate = Fate::Rewritten;
  };

  /// `context` must outlive the object.
  explicit ModuleRewriter(ScanContext& context) : context_(&context) {}

  /// Appends what becomes of the module to `output`. `draw` is the selection draw of the compatible modes. At a cut
  /// symbol nothing is appended, and the caller removes the part behind it. Adds to the context's record, if it has
  /// one.
  Outcome rewrite(const SystemTables& tables, const ScanPlace& place, double draw, ModuleString& output) {
    return context_->record == nullptr ? rewriteSilently(tables, place, draw, output)
                                       : rewriteRecorded(tables, place, draw, output);
  }
  /// Rewrites the module at `place` into the context's output, and moves `place` behind the modules that it consumed or
  /// cut.
  void rewriteNext(const SystemTables& tables, double draw, ScanPlace& place);
  /// Removes the part behind the cut symbol at `place`. A scan with rules of its own for a part's end gives the part.
  StringPart cut(const ScanPlace& place);
  void cut(const ScanPlace& place, const StringPart& part);

 private:
  Outcome rewriteSilently(const SystemTables& tables, const ScanPlace& place, double draw, ModuleString& output);
  Outcome rewriteRecorded(const SystemTables& tables, const ScanPlace& place, double draw, ModuleString& output);
  [[nodiscard]] std::size_t longestPredecessor(const SystemTables& tables) const;

  ScanContext* context_;
};

}  // namespace espalier::derivation

#include "engine/derivation/scan/recorded_scan.h"

namespace espalier::derivation {

void RecordedScan::run() {
  ScanContext& context = *context_;
  const SystemTables& tables = context.tables.front();
  const bool drawsEachPosition = context.drawsEachPosition(*tables.system);
  for (ScanPlace place; place.module < context.old->size();) {
    if ((place.module & 0xFFFFU) == 0) {
      context.evaluator.pollCancelled();
    }
    const double draw = drawsEachPosition ? context.random.selection(context.step, place.module) : 0.0;
    rewriter_->rewriteNext(tables, draw, place);
    context.rewriter.checkSize(context.output.size(), context.output.parameterCount());
  }
}

}  // namespace espalier::derivation

#include "engine/derivation/scan/backward_scan.h"

namespace espalier::derivation {

void BackwardScan::run() {
  ScanContext& context = *context_;
  const SystemTables& tables = context.tables.front();
  const ModuleString& old = *context.old;
  const bool drawsEachPosition = context.drawsEachPosition(*tables.system);
  pieces_.clear();
  for (ScanPlace place{old.size(), old.parameterCount()}; place.module-- > 0;) {
    if ((place.module & 0xFFFU) == 0) {
      context.evaluator.pollCancelled();
    }
    place.offset -= context.program.arity[old.types()[place.module]];
    pieces_.begin();
    const double draw = drawsEachPosition ? context.random.selection(context.step, place.module) : 0.0;
    const ModuleRewriter::Outcome outcome = rewriter_->rewrite(tables, place, draw, pieces_.modules());
    if (outcome.fate == ModuleRewriter::Fate::Cut) {
      // the part right of the cut is produced already
      const StringPart part = rewriter_->cut(place);
      pieces_.dropBefore(part.endModule - part.firstModule);
    }
    context.rewriter.checkSize(pieces_.modules().size(), pieces_.modules().parameterCount());
  }
  pieces_.appendTo(context.output);
  std::uint64_t begin = 0;
  for (std::uint64_t module = 0; context.origins != nullptr && module < old.size(); ++module) {
    const std::uint64_t end = begin + pieces_.sizeOf(old.size() - 1 - module);
    context.origins->add(context.program, old, module, module + 1, context.output, begin, end);
    begin = end;
  }
}

}  // namespace espalier::derivation

#include "engine/derivation/scan/backward_scan.h"

#include <vector>

namespace espalier::derivation {

void BackwardScan::run() {
  ScanContext& context = *context_;
  const SystemTables& tables = context.tables.front();
  const ModuleString& old = *context.old;
  const bool drawsEachPosition = context.drawsEachPosition(*tables.system);
  pieces_.clear();
  // the `]` of the branches that the scan is in
  std::vector<ScanPlace> branchEnds;
  for (ScanPlace place{old.size(), old.parameterCount()}; place.module-- > 0;) {
    if ((place.module & 0xFFFU) == 0) {
      context.evaluator.pollCancelled();
    }
    const core::ModuleTypeId type = old.types()[place.module];
    place.offset -= context.program.arity[type];
    if (type == context.program.closeBranch) {
      branchEnds.push_back(place);
    } else if (type == context.program.openBranch && !branchEnds.empty()) {
      branchEnds.pop_back();
    }
    pieces_.begin();
    const double draw = drawsEachPosition ? context.random.selection(context.step, place.module) : 0.0;
    const ModuleRewriter::Outcome outcome = rewriter_->rewrite(tables, place, draw, pieces_.modules());
    if (outcome.fate == ModuleRewriter::Fate::Cut) {
      // the part right of the cut is produced already, and what it cut itself is kept
      const ScanPlace end = branchEnds.empty() ? ScanPlace{old.size(), old.parameterCount()} : branchEnds.back();
      const StringPart part{place.module + 1, end.module, place.offset + outcome.parameters, end.offset};
      context.cuts.dropInside(part);
      rewriter_->cut(place, part);
      pieces_.dropBefore(part.endModule - part.firstModule);
    }
    context.rewriter.checkSize(pieces_.modules().size(), pieces_.modules().parameterCount());
  }
  pieces_.appendTo(context.output);
  context.cuts.reverse();
  if (context.origins == nullptr) {
    return;
  }
  std::uint64_t module = 0;
  std::uint64_t begin = 0;
  for (std::size_t piece = pieces_.count(); piece-- > 0;) {
    const std::uint64_t end = begin + pieces_.sizeOf(piece);
    for (std::uint64_t i = 0; i < pieces_.oldModulesOf(piece); ++i, ++module) {
      context.origins->add(context.program, old, module, module + 1, context.output, begin, end);
    }
    begin = end;
  }
}

}  // namespace espalier::derivation

#include "engine/derivation/scan/general_scan.h"

#include <algorithm>
#include <bit>

namespace espalier::derivation {

void GeneralScan::run() {
  ScanContext& context = *context_;
  const SystemTables& tables = context.tables.front();
  const bool drawsEachPosition = context.drawsEachPosition(*tables.system);
  KeptModules kept;
  for (ScanPlace place; place.module < context.old->size();) {
    if ((place.module & 0xFFFFU) == 0) {
      context.evaluator.pollCancelled();
    }
    const ScanPlace before = place;
    const std::uint64_t module = context.output.size();
    const std::uint64_t parameter = context.output.parameterCount();
    const double draw = drawsEachPosition ? context.random.selection(context.step, place.module) : 0.0;
    rewriter_->rewriteNext(tables, draw, place);
    context.rewriter.checkSize(context.output.size(), context.output.parameterCount());
    context.noteOrigins(before.module, place.module, module);
    if (context.changes == nullptr) {
      continue;
    }
    if (!isAsItWas(before, place, module, parameter)) {
      note(kept);
      kept = {place.module, context.output.size(), 0};
    } else {
      ++kept.modules;
    }
  }
  if (context.changes != nullptr) {
    context.changes->keep(kept.from, kept.to, kept.modules);
  }
}

bool GeneralScan::isAsItWas(const ScanPlace& begin, const ScanPlace& end, std::uint64_t module,
                            std::uint64_t parameter) const {
  const ModuleString& old = *context_->old;
  const ModuleString& made = context_->output;
  if (end.module != begin.module + 1 || made.size() != module + 1 ||
      made.types()[module] != old.types()[begin.module]) {
    return false;
  }
  const auto values = old.parameters().subspan(begin.offset, end.offset - begin.offset);
  const auto now = made.parameters().subspan(parameter);
  return std::equal(values.begin(), values.end(), now.begin(), now.end(), [](double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  });
}

void GeneralScan::note(const KeptModules& kept) {
  if (kept.modules >= StepChanges::kShortestRun || kept.from == 0) {
    context_->changes->keep(kept.from, kept.to, kept.modules);
  }
}

}  // namespace espalier::derivation

#include "engine/derivation/scan/general_scan.h"

namespace espalier::derivation {
namespace {

// between two looks at what stays as it was: what changes inside is sent to viewers as a whole
constexpr std::uint64_t kChunkModules = 256;
// between two looks at `cancelled`
constexpr std::uint64_t kPolledChunks = 256;

}  // namespace

void GeneralScan::run() {
  ScanContext& context = *context_;
  const SystemTables& tables = context.tables.front();
  const bool drawsEachPosition = context.drawsEachPosition(*tables.system);
  ScanPlace place;
  for (std::uint64_t chunk = 0; place.module < context.old->size(); ++chunk) {
    if (chunk % kPolledChunks == 0) {
      context.evaluator.pollCancelled();
    }
    const ScanPlace begin = place;
    const std::uint64_t modules = context.output.size();
    const std::uint64_t parameters = context.output.parameterCount();
    while (place.module < context.old->size() && place.module < begin.module + kChunkModules) {
      const double draw = drawsEachPosition ? context.random.selection(context.step, place.module) : 0.0;
      rewriter_->rewriteNext(tables, draw, place);
      context.rewriter.checkSize(context.output.size(), context.output.parameterCount());
    }
    context.noteEqualEnds(begin, place, modules, parameters);
  }
}

}  // namespace espalier::derivation

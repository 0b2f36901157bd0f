#include "engine/derivation/scan/decomposition_passes.h"

#include <algorithm>
#include <utility>

#include "engine/derivation/scan/batch_scan.h"

namespace espalier::derivation {

DecompositionPasses::DecompositionPasses(ScanContext& context)
    : context_(&context),
      list_(&context.tables.front().system->decomposition),
      batch_(context.program, context.tables.front().rules, *context.tables.front().decomposition,
             context.tables.front().plan) {}

bool DecompositionPasses::run(ModuleString& made) {
  stores_.clear();
  bool isChanged = true;
  for (std::uint32_t depth = 0; isChanged && depth < list_->maximumDepth; ++depth) {
    if (!pass(made, isChanged)) {
      return false;
    }
    if (isChanged) {
      if (depth >= context_->options.limits.maximumRecursion || context_->isCancelled()) {
        return false;
      }
      made.swap(next_);
      std::swap(stores_, moved_);
    }
  }
  // the Rewriter warns once where more productions would apply
  if (isChanged && list_->warnsAtDepth && !context_->rewriter.hasWarnedAbout(*list_)) {
    begin(made);
    std::uint64_t offset = 0;
    for (std::uint64_t first = 0; first < made.size();) {
      const BatchRewriter::Outcome outcome =
          batch_.choose(first, std::min(made.size(), first + BatchRewriter::kChunkModules), offset);
      if (outcome.isChanged || outcome.isUnusual) {
        return false;
      }
      first = outcome.endModule;
      offset = outcome.endParameter;
    }
  }
  return true;
}

void DecompositionPasses::begin(const ModuleString& made) {
  BatchRewriter::Step step = batchStep(*context_);
  step.old = {made.types().data(), made.parameters().data(), made.size(), made.parameterCount(), step.old.index, false};
  batch_.begin(step);
}

bool DecompositionPasses::pass(const ModuleString& made, bool& isChanged) {
  begin(made);
  isChanged = false;
  next_.clear();
  moved_.clear();
  std::uint64_t offset = 0;
  for (std::uint64_t first = 0; first < made.size();) {
    const BatchRewriter::Outcome outcome =
        batch_.choose(first, std::min(made.size(), first + BatchRewriter::kChunkModules), offset);
    const std::uint64_t modules = next_.size();
    const std::uint64_t parameters = next_.parameterCount();
    if (outcome.isUnusual ||
        !context_->isWithinLimits(modules + outcome.moduleCount, parameters + outcome.parameterCount)) {
      return false;
    }
    next_.typeBuffer().resize(modules + outcome.moduleCount);
    next_.parameterBuffer().resize(parameters + outcome.parameterCount);
    if (!batch_.write(next_.typeBuffer().data() + modules, next_.parameterBuffer().data() + parameters)) {
      return false;
    }
    // depth first, what a module becomes comes behind it and before the next module: so do the places in a level
    stores_.noteAll(batch_.stores());
    stores_.moveTo(
        first, outcome.endModule, [&](std::uint64_t module) { return modules + batch_.placeOfResult(module); }, moved_);
    isChanged = isChanged || outcome.isChanged;
    first = outcome.endModule;
    offset = outcome.endParameter;
  }
  return true;
}

}  // namespace espalier::derivation

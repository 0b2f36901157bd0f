// The scan of a model without sub-L-systems in batches, and what of it only the general way can do.
#include <algorithm>

#include "engine/derivation/implementation.h"

namespace espalier::derivation {
namespace {

// shorter strings are not worth the setting up of batches; contexts are, sooner
constexpr std::uint64_t kBatchedModules = 256;
constexpr std::uint64_t kBatchedModulesWithContexts = 48;
// without contexts, making a BatchScan costs as much as scanning some hundred modules one at a time
constexpr std::uint64_t kFirstModules = 1024;
// a batch shorter than this, before a module that needs the general way, is not worth its setting up
constexpr std::uint64_t kWorthwhileModules = 256;
// the longest stretch that is left to the general way before batches are tried again
constexpr std::uint64_t kGeneralModules = 8192;
// modules that are left to one at a time where light productions rewrite at least every third one
constexpr std::uint64_t kLightModules = 65536;
constexpr std::uint64_t kLightShare = 3;

}  // namespace

bool Derivation::Implementation::isWithinLimits(std::uint64_t moduleCount, std::uint64_t parameterCount) const {
  return moduleCount <= options_.limits.maximumModules &&
         moduleCount * 2 + parameterCount * 8 <= options_.limits.maximumStringBytes;
}

BatchScan::Step Derivation::Implementation::batchStep(const PlantState& state) const {
  return {rewriter_.around(),
          static_cast<std::uint32_t>(step_),
          static_cast<double>(state.derivationLength),
          random_.selectionSource(),
          random_.mainSource(),
          rewriter_.storesFloats(),
          evaluator_.hasWarned()};
}

bool Derivation::Implementation::appendBatch(const BatchScan::Outcome& outcome) {
  const std::uint64_t modules = working_.size();
  const std::uint64_t parameters = working_.parameterCount();
  if (outcome.isUnusual || !isWithinLimits(modules + outcome.moduleCount, parameters + outcome.parameterCount)) {
    return false;
  }
  reserveOutput(modules + outcome.moduleCount, parameters + outcome.parameterCount);
  if (!batches_.front()->write(working_.typeBuffer().data() + modules,
                               working_.parameterBuffer().data() + parameters)) {
    return false;
  }
  working_.typeBuffer().resize(modules + outcome.moduleCount);
  working_.parameterBuffer().resize(parameters + outcome.parameterCount);
  return true;
}

bool Derivation::Implementation::usesBatches(const ModuleString& old) const {
  const bool isWorthwhile = program_->hasContexts
                                ? old.size() >= kBatchedModulesWithContexts
                                : old.size() >= kBatchedModules && scannedModules_ + old.size() >= kFirstModules;
  return isWorthwhile && tables_.front().batches.isUseful() &&
         !(random_.isSequential() && program_->systems.front().isStochastic);
}

void Derivation::Implementation::scanInBatches(const PlantState& state, std::uint64_t end, ScanPlace& place) {
  const SystemTables& tables = tables_.front();
  if (batches_.empty()) {
    batches_.push_back(std::make_unique<BatchScan>(*program_, tables.rules, tables.batches, tables.plan));
  }
  BatchScan& batch = *batches_.front();
  std::uint64_t chunk = generalModules_ > 1 ? kWorthwhileModules : BatchScan::kChunkModules;
  while (place.module < end) {
    if (modulesAlone_ > 0) {
      const std::uint64_t first = place.module;
      scanUpTo(state, std::min(end, first + modulesAlone_), place);
      modulesAlone_ -= std::min(modulesAlone_, place.module - first);
      continue;
    }
    evaluator_.clearModule();
    evaluator_.pollCancelled();
    // blocks of the general way may have changed Z
    batch.begin(batchStep(state));
    const std::uint64_t chunkEnd = std::min(end, place.module + chunk);
    const BatchScan::Outcome outcome = batch.choose(place.module, chunkEnd, place.offset);
    const std::uint64_t batched = outcome.endModule - place.module;
    const std::uint64_t target = working_.size();
    if (appendBatch(outcome)) {
      if (outcome.isKept && !state.string.wereSet(place.offset, outcome.parameterCount)) {
        keptModules_.note(place.module, target, batched);
      }
      place = {outcome.endModule, outcome.endParameter};
    } else {
      // a failure or a warning, in the order of the string
      scanUpTo(state, outcome.endModule, place);
      rewriter_.checkSize(working_.size(), working_.parameterCount());
    }
    if (tables.batches.isQuick() && outcome.lightSites * kLightShare > batched) {
      modulesAlone_ = kLightModules;
    }
    if (outcome.endModule == chunkEnd) {
      chunk = std::min(2 * chunk, BatchScan::kChunkModules);
      continue;
    }
    // a module for the general way; where these stand close together, so do the ones between them
    generalModules_ = batched < kWorthwhileModules ? std::min(2 * generalModules_, kGeneralModules) : 1;
    chunk = std::clamp(2 * batched, kWorthwhileModules, BatchScan::kChunkModules);
    modulesAlone_ = std::max(modulesAlone_, generalModules_);
  }
}

}  // namespace espalier::derivation

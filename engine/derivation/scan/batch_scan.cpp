#include "engine/derivation/scan/batch_scan.h"

#include <algorithm>

namespace espalier::derivation {
namespace {

// shorter strings are not worth the setting up of batches; contexts are, sooner
constexpr std::uint64_t kBatchedModules = 256;
constexpr std::uint64_t kBatchedModulesWithContexts = 48;
// making a BatchRewriter costs as much as scanning some hundred modules one at a time
constexpr std::uint64_t kFirstModules = 1024;
// with contexts or code, a batch costs as much as six modules one at a time, and less for each further one
constexpr std::uint64_t kBatchedModulesLater = 16;
// a batch shorter than this, before a module that needs the general way, is not worth its setting up
constexpr std::uint64_t kWorthwhileModules = 256;
// the longest stretch that is left to the PlainScan before batches are tried again
constexpr std::uint64_t kLongestStretch = 8192;
// modules that are left to the PlainScan where light productions rewrite at least every third module
constexpr std::uint64_t kLightModules = 65536;
constexpr std::uint64_t kLightShare = 3;

}  // namespace

BatchRewriter::Step batchStep(const ScanContext& context) {
  const InstanceState& variables = context.plant->instances.front();
  return {context.rewriter.around(),
          static_cast<std::uint32_t>(context.step),
          {static_cast<double>(context.step), static_cast<double>(context.plant->derivationLength),
           context.evaluator.hasWarned(), variables.variables.data(), variables.elements.data(),
           context.random.mainSource()},
          context.random.selectionSource(),
          context.rewriter.storesFloats()};
}

bool BatchScan::isWorthwhile(const ModuleString& old) const {
  const SystemTables& tables = context_->tables.front();
  // code of the ModuleRewriter and the Evaluator costs so much that batches gain sooner
  const bool isLater = context_->scannedModules + old.size() >= kFirstModules;
  const bool isLongEnough = context_->program.hasContexts || !tables.batches.isCheap()
                                ? old.size() >= (isLater ? kBatchedModulesLater : kBatchedModulesWithContexts)
                                : old.size() >= kBatchedModules && isLater;
  return isLongEnough && tables.batches.isUseful() && !context_->drawsEachPosition(*tables.system);
}

bool BatchScan::append(const BatchRewriter::Outcome& outcome) {
  ModuleString& output = context_->output;
  const std::uint64_t modules = output.size();
  const std::uint64_t parameters = output.parameterCount();
  if (outcome.isUnusual ||
      !context_->isWithinLimits(modules + outcome.moduleCount, parameters + outcome.parameterCount)) {
    return false;
  }
  context_->reserveOutput(modules + outcome.moduleCount, parameters + outcome.parameterCount);
  if (!batch_->write(output.typeBuffer().data() + modules, output.parameterBuffer().data() + parameters)) {
    return false;
  }
  output.typeBuffer().resize(modules + outcome.moduleCount);
  output.parameterBuffer().resize(parameters + outcome.parameterCount);
  return true;
}

bool BatchScan::appendDecomposed(const BatchRewriter::Outcome& outcome) {
  if (outcome.isUnusual || !context_->isWithinLimits(outcome.moduleCount, outcome.parameterCount)) {
    return false;
  }
  made_.clear();
  made_.typeBuffer().resize(outcome.moduleCount);
  made_.parameterBuffer().resize(outcome.parameterCount);
  if (!batch_->write(made_.typeBuffer().data(), made_.parameterBuffer().data())) {
    return false;
  }
  ModuleString& output = context_->output;
  if (!decomposition_->run(made_) ||
      !context_->isWithinLimits(output.size() + made_.size(), output.parameterCount() + made_.parameterCount())) {
    return false;
  }
  context_->reserveOutput(output.size() + made_.size(), output.parameterCount() + made_.parameterCount());
  output.appendAll(made_.types(), made_.parameters());
  return true;
}

void BatchScan::run(std::uint64_t end, ScanPlace& place) {
  ScanContext& context = *context_;
  const SystemTables& tables = context.tables.front();
  if (batch_ == nullptr) {
    batch_ = std::make_unique<BatchRewriter>(context.program, tables.rules, tables.batches, tables.plan);
    if (tables.decomposition) {
      decomposition_ = std::make_unique<DecompositionPasses>(context);
    }
  }
  std::uint64_t chunk = generalStretch_ > 1 ? kWorthwhileModules : BatchRewriter::kChunkModules;
  while (place.module < end) {
    if (plainModules_ > 0) {
      const std::uint64_t first = place.module;
      plain_->run(std::min(end, first + plainModules_), place);
      plainModules_ -= std::min(plainModules_, place.module - first);
      continue;
    }
    context.evaluator.clearModule();
    context.evaluator.pollCancelled();
    // blocks of the general way may have changed variables and Z
    batch_->begin(batchStep(context));
    const std::uint64_t chunkEnd = std::min(end, place.module + chunk);
    const BatchRewriter::Outcome outcome = batch_->choose(place.module, chunkEnd, place.offset);
    const std::uint64_t batched = outcome.endModule - place.module;
    const std::uint64_t target = context.output.size();
    const std::uint64_t targetParameter = context.output.parameterCount();
    if (decomposition_ == nullptr ? append(outcome) : appendDecomposed(outcome)) {
      if (decomposition_ != nullptr) {
        context.noteEqualEnds(place, {outcome.endModule, outcome.endParameter}, target, targetParameter);
      } else if (context.changes != nullptr) {
        batch_->noteKept(target, *context.changes);
      }
      batch_->stores().apply(context.plant->statics);
      if (decomposition_ != nullptr) {
        decomposition_->stores().apply(context.plant->statics);
      }
      place = {outcome.endModule, outcome.endParameter};
    } else {
      // a failure or a warning, in the order of the string
      plain_->run(outcome.endModule, place);
      context.rewriter.checkSize(context.output.size(), context.output.parameterCount());
    }
    if (tables.batches.isQuick() && outcome.lightSites * kLightShare > batched) {
      plainModules_ = kLightModules;
    }
    if (outcome.endModule >= chunkEnd) {
      chunk = std::min(2 * chunk, BatchRewriter::kChunkModules);
      continue;
    }
    // a module for the general way; where these stand close together, so do the ones between them
    generalStretch_ = batched < kWorthwhileModules ? std::min(2 * generalStretch_, kLongestStretch) : 1;
    chunk = std::clamp(2 * batched, kWorthwhileModules, BatchRewriter::kChunkModules);
    plainModules_ = std::max(plainModules_, generalStretch_);
  }
}

}  // namespace espalier::derivation

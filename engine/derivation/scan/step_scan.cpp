#include "engine/derivation/scan/step_scan.h"

#include <algorithm>
#include <new>

#include "engine/derivation/parallel/parallel_batch_scan.h"
#include "engine/derivation/parallel/parallel_general_scan.h"

namespace espalier::derivation {
namespace {

// more threads than this wait for the memory and for each other
constexpr unsigned kMostThreads = 64;
// modules or parameters that are reserved beyond the estimate
constexpr std::uint64_t kReserve = 64;
// Of one step; a string that unfolds at once does not go on so. One that does grows without a copy once it is large.
constexpr double kMostGrowth = 8.0;

}  // namespace

StepScan::StepScan(ScanContext& context, SubSystems& calls)
    : context_(&context),
      threadCount_(std::clamp(context.options.threads, 1U, kMostThreads)),
      needsLinks_(std::any_of(context.tables.begin(), context.tables.end(),
                              [](const SystemTables& tables) { return tables.hasContexts; })),
      rewriter_(context),
      plain_(context, rewriter_),
      batch_(context, plain_),
      general_(context, rewriter_),
      backward_(context, rewriter_),
      subSystems_(context, rewriter_, calls) {}

StepScan::~StepScan() = default;

StepScan::Kind StepScan::chooseKind(const ModuleString& old) const {
  const SystemTables& tables = context_->tables.front();
  const DerivationOptions& options = context_->options;
  // the needs of the model come first
  if (context_->program.hasSubSystems) {
    return Kind::SubSystems;
  }
  if (tables.isProducedBackwards) {
    return Kind::Backward;
  }
  // a caller that wants to know every application gets the way without shortcuts
  if (context_->record != nullptr || context_->isCounted || context_->origins != nullptr) {
    return Kind::General;
  }
  // a long string by several threads, where the result does not depend on their order
  if (threadCount_ > 1 && old.size() >= options.threadedModules) {
    // the draws of the compatible modes are one sequence: a thread that goes ahead would take those of another
    const bool drawsInSequence =
        context_->drawsEachPosition(*tables.system) || (context_->random.isSequential() && tables.drawsRandom);
    if (tables.batches.isChunkable() && !drawsInSequence) {
      return Kind::ParallelBatch;
    }
    if (tables.isOrderFree && !drawsInSequence) {
      return Kind::ParallelGeneral;
    }
  }
  // else by one thread: a chunk of modules at a time where that gains, or module by module
  return batch_.isWorthwhile(old) ? Kind::Batch : Kind::Plain;
}

void StepScan::run() {
  const ModuleString& old = context_->plant->string;
  const Kind kind = chooseKind(old);
  begin(kind, old);
  ScanPlace start;
  StringIndex* const links = needsLinks_ && !areLinksRight_ ? &context_->index : nullptr;
  switch (kind) {
    case Kind::SubSystems:
      subSystems_.run();
      break;
    case Kind::Backward:
      backward_.run();
      break;
    case Kind::General:
      general_.run();
      break;
    case Kind::ParallelBatch:
      if (parallelBatch_ == nullptr) {
        parallelBatch_ = std::make_unique<ParallelBatchScan>(*context_, plain_, team());
      }
      parallelBatch_->run(links);
      break;
    case Kind::ParallelGeneral:
      if (parallelGeneral_ == nullptr) {
        parallelGeneral_ = std::make_unique<ParallelGeneralScan>(*context_, plain_, team());
      }
      parallelGeneral_->run(links);
      break;
    case Kind::Batch:
      batch_.run(old.size(), start);
      break;
    case Kind::Plain:
      plain_.run(old.size(), start);
      break;
  }
  finish(kind, old);
}

void StepScan::begin(Kind kind, const ModuleString& old) {
  ScanContext& context = *context_;
  // signals run through strings whose branches stay where they are: the links of the last step serve again
  areLinksRight_ = context.isOutputIndexed && context.index.isShared(context.output.types(), old.types());
  context.isOutputIndexed = false;
  context.rotation.clear(context.output);
  context.cuts.clear();
  // several threads link brackets with the scan
  const bool isParallel = kind == Kind::ParallelBatch || kind == Kind::ParallelGeneral;
  if (needsLinks_ && !areLinksRight_ && !isParallel) {
    context.buildIndex(old);
    areLinksRight_ = true;
  }
  const bool isBackward = kind == Kind::Backward;
  context.read(old, context.index, isBackward ? nullptr : &context.output, isBackward ? &backward_.pieces() : nullptr);
  reserveEstimate(old);
}

void StepScan::finish(Kind kind, const ModuleString& old) {
  ScanContext& context = *context_;
  // the other kinds note what they leave as it was on their way
  if (kind == Kind::SubSystems || kind == Kind::Backward) {
    context.noteEqualEnds({}, {old.size(), old.parameterCount()}, 0, 0);
  }
  context.scannedModules += old.size();
  context.cuts.appendTo(context.output, old, context.evaluator);
  context.rewriter.checkSize(context.output.size(), context.output.parameterCount());
  context.evaluator.clearModule();
  if (old.size() > 0) {
    moduleGrowth_ = static_cast<double>(context.output.size()) / static_cast<double>(old.size());
  }
  if (old.parameterCount() > 0) {
    parameterGrowth_ = static_cast<double>(context.output.parameterCount()) / static_cast<double>(old.parameterCount());
  }
}

void StepScan::swapStrings() {
  ModuleString& string = context_->plant->string;
  string.swap(context_->output);
  context_->isOutputIndexed = needsLinks_;
}

void StepScan::reserveEstimate(const ModuleString& old) {
  // memory that is reserved and never touched costs nothing, copying a string that outgrew its buffer does
  const auto estimate = [](std::uint64_t size, double growth, std::uint64_t bound) {
    const double wanted = static_cast<double>(size) * std::min(growth, kMostGrowth) * 1.1;
    return std::min(wanted < 1.0e18 ? static_cast<std::uint64_t>(wanted) : bound, bound) + kReserve;
  };
  const core::Limits& limits = context_->options.limits;
  try {
    context_->reserveOutput(
        estimate(old.size(), moduleGrowth_, std::min(limits.maximumModules, limits.maximumStringBytes / 2)),
        estimate(old.parameterCount(), parameterGrowth_, limits.maximumStringBytes / 8));
  } catch (const std::bad_alloc&) {
    // a system that bounds the address space of its programs may have room for the string, if not for the estimate
  }
}

core::WorkerTeam& StepScan::team() {
  if (team_ == nullptr) {
    team_ = std::make_unique<core::WorkerTeam>(threadCount_);
  }
  return *team_;
}

}  // namespace espalier::derivation

// The scan of a long string by several threads where batches cannot do every module: predecessors of several modules,
// the cut symbol, decomposition, draws wherever they stand. Each thread has a helper, an Implementation of its own,
// which rewrites a chunk into a string of its own, beginning where the chunk does; chunks are taken in order and copied
// into place in order. A chunk that an earlier one has reached into, that failed, that warned or that does not fit
// stops the threads, and the calling thread does it: the results, the first failure and the warnings are those of one
// thread.
#include <algorithm>

#include "engine/derivation/batch/scan_round.h"
#include "engine/derivation/batch/shared_output.h"
#include "engine/derivation/implementation.h"

namespace espalier::derivation {
namespace {

// modules of a chunk: enough to be worth taking, few enough to stay in the caches and to keep all threads at work
constexpr std::uint64_t kLeastModules = 256;
constexpr std::uint64_t kMostModules = 8192;
constexpr std::uint64_t kChunksPerThread = 8;

}  // namespace

bool Derivation::Implementation::canScanInParts(const ModuleString& old) const {
  const SystemTables& tables = tables_.front();
  // the draws of the compatible modes are one sequence
  return isThreaded(old) && tables.isOrderFree &&
         !(random_.isSequential() && (tables.drawsRandom || program_->systems.front().isStochastic));
}

Derivation::Implementation::ScanPlace Derivation::Implementation::chunkStart(const ModuleString& old,
                                                                             std::uint64_t chunk) const {
  const std::vector<std::uint8_t>& isInside = tables_.front().isInside;
  const core::ModuleTypeId* types = old.types().data();
  ScanPlace place{std::min(chunk * chunkModules_, old.size()), chunkOffsets_[chunk]};
  if (chunk == 0) {
    return place;
  }
  // not where a predecessor may have begun before, if there is such a place near by
  const std::uint64_t last = std::min(place.module + chunkModules_ / 2, old.size());
  while (place.module < last && isInside[types[place.module]] != 0) {
    place.offset += program_->arity[types[place.module]];
    ++place.module;
  }
  return place;
}

std::unique_ptr<Derivation::Implementation> Derivation::Implementation::makeHelper() const {
  DerivationOptions options = options_;
  options.threads = 1;
  options.messages = nullptr;
  auto helper = std::make_unique<Implementation>(*program_, std::move(options));
  bool& hasWarned = helper->hasPartWarned_;
  helper->evaluator_.setMessages([&hasWarned](core::MessageKind, std::string_view) { hasWarned = true; });
  return helper;
}

void Derivation::Implementation::beginParts(const PlantState& state, const Implementation& owner) {
  scannedModules_ = owner.scannedModules_;
  partState_.step = state.step;
  partState_.derivationLength = state.derivationLength;
  partState_.isStopped = state.isStopped;
  partState_.statics = state.statics;
  partState_.instances.assign(state.instances.begin(), state.instances.begin() + 1);
  partState_.random = state.random;
  partState_.viewVolume = state.viewVolume;
  attach(partState_, owner.step_, owner.step_);
  shortcuts_.clear();
  rewriter_.setStrings({state.string.types().data(), state.string.parameters().data(), state.string.size(),
                        state.string.parameterCount(), &owner.index_, true, &shortcuts_},
                       nullptr);
}

bool Derivation::Implementation::scanPart(const PlantState& state, std::uint64_t end, ScanPlace& place) {
  working_.clear();
  keptParts_.clear();
  hasPartWarned_ = false;
  try {
    if (usesBatches(state.string)) {
      scanInBatches(state, end, place);
    } else {
      scanUpTo(state, end, place);
    }
  } catch (...) {
    // the owner meets the same failure, in the order of the string
    return false;
  }
  return !hasPartWarned_;
}

std::uint64_t Derivation::Implementation::scanPartRound(const PlantState& state, std::uint64_t firstChunk,
                                                        ScanPlace& place) {
  ScanRound round(firstChunk, chunkOffsets_.size() - 1);
  round.modules = working_.size();
  round.parameters = working_.parameterCount();
  SharedOutput output(working_);

  team_->onEveryWorker([&](unsigned worker) {
    Implementation& helper = *helpers_[worker];
    const ModuleString& made = helper.working_;
    for (std::uint64_t chunk = 0; round.take(chunk);) {
      const ScanPlace begin = chunkStart(state.string, chunk);
      const std::uint64_t end = chunkStart(state.string, chunk + 1).module;
      ScanPlace reached = begin;
      const bool isDone = helper.scanPart(state, end, reached);
      if (!round.awaitTurn(chunk)) {
        return;
      }
      // cut, all of it
      if (place.module >= end) {
        round.passTurn(chunk);
        continue;
      }
      const std::uint64_t modules = round.modules;
      const std::uint64_t parameterCount = round.parameters;
      const std::uint64_t endModules = modules + made.size();
      const std::uint64_t endParameters = parameterCount + made.parameterCount();
      if (!isDone || place.module != begin.module || !isWithinLimits(endModules, endParameters) ||
          !output.holds(endModules, endParameters)) {
        round.stopAt(chunk);
        return;
      }
      place = reached;
      round.modules = endModules;
      round.parameters = endParameters;
      keptParts_.insert(keptParts_.end(), helper.keptParts_.begin(), helper.keptParts_.end());
      round.passTurn(chunk);
      output.prepare(modules, endModules, parameterCount, endParameters);
      std::copy_n(made.types().data(), made.size(), output.types() + modules);
      std::copy_n(made.parameters().data(), made.parameterCount(), output.parameters() + parameterCount);
    }
  });
  output.finish(round.modules, round.parameters);
  return round.end();
}

void Derivation::Implementation::scanInParts(const PlantState& state) {
  const ModuleString& old = state.string;
  makeTeam();
  while (helpers_.size() < threadCount_) {
    helpers_.push_back(makeHelper());
  }
  findChunkOffsets(old, std::clamp(old.size() / (kChunksPerThread * threadCount_), kLeastModules, kMostModules));
  for (const auto& helper : helpers_) {
    helper->beginParts(state, *this);
  }
  ScanPlace place;
  const std::uint64_t chunkCount = chunkOffsets_.size() - 1;
  for (std::uint64_t chunk = 0; chunk < chunkCount;) {
    // what has been reported is not reported again, and what has not been is noticed
    for (const auto& helper : helpers_) {
      helper->evaluator_.adoptWarnings(evaluator_);
      helper->rewriter_.adoptWarnings(rewriter_);
    }
    chunk = scanPartRound(state, chunk, place);
    if (chunk < chunkCount) {
      evaluator_.clearModule();
      evaluator_.pollCancelled();
      scanUpTo(state, std::max(chunkStart(old, chunk + 1).module, place.module), place);
      rewriter_.checkSize(working_.size(), working_.parameterCount());
      ++chunk;
    }
  }
}

}  // namespace espalier::derivation

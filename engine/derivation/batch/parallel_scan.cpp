// The scan of a long string by several threads. Chunks are taken in order; each thread chooses for its chunk, waits
// until the chunk before has said how long its result is, says how long its own is, and writes into place. Waiting is
// short because counting never waits for writing. What a batch cannot do stops the threads before that chunk, and the
// calling thread does the chunk in the general way: the results, the first failure and the warnings are those of the
// scan on one thread, whatever the number of threads.
#include <algorithm>
#include <atomic>
#include <mutex>

#include "engine/derivation/batch/scan_round.h"
#include "engine/derivation/batch/shared_output.h"
#include "engine/derivation/implementation.h"

namespace espalier::derivation {
namespace {

// chunks whose parameters are counted, and brackets linked, by one thread at a time
constexpr std::uint64_t kPartChunks = 16;
// of a chunk that is only counted and written: long enough that threads seldom meet in one page
constexpr std::uint64_t kFixedChunkModules = 16 * BatchScan::kChunkModules;

}  // namespace

bool Derivation::Implementation::isThreaded(const ModuleString& old) const {
  return old.size() >= options_.threadedModules && threadCount_ > 1 && record_ == nullptr && !program_->hasSubSystems;
}

bool Derivation::Implementation::canScanInParallel(const ModuleString& old) {
  const BatchPlan& plan = tables_.front().batches;
  return isThreaded(old) && plan.isComplete() && !(random_.isSequential() && program_->systems.front().isStochastic);
}

void Derivation::Implementation::makeTeam() {
  if (team_ == nullptr) {
    team_ = std::make_unique<core::WorkerTeam>(threadCount_);
  }
}

void Derivation::Implementation::findChunkOffsets(const ModuleString& old, std::uint64_t chunkModules) {
  const std::uint64_t size = old.size();
  chunkModules_ = chunkModules;
  const std::uint64_t chunkCount = (size + chunkModules_ - 1) / chunkModules_;
  const std::uint64_t partCount = (chunkCount + kPartChunks - 1) / kPartChunks;
  const bool needsLinks = needsIndex(program_->systems.front()) && !areLinksKept_;
  chunkOffsets_.assign(chunkCount + 1, 0);
  if (needsLinks) {
    index_.beginParts(size);
    openEnds_.resize(std::max<std::uint64_t>(openEnds_.size(), partCount));
  }
  if (old.parameterCount() == 0 && !needsLinks) {
    return;
  }
  // each part on its own
  std::atomic<std::uint64_t> next{0};
  team_->onEveryWorker([&](unsigned) {
    const core::ModuleTypeId* types = old.types().data();
    for (std::uint64_t part = next++; part < partCount; part = next++) {
      const std::uint64_t firstChunk = part * kPartChunks;
      const std::uint64_t endChunk = std::min(firstChunk + kPartChunks, chunkCount);
      for (std::uint64_t chunk = firstChunk; chunk < endChunk; ++chunk) {
        const std::uint64_t first = chunk * chunkModules_;
        chunkOffsets_[chunk + 1] = parameterSum_.of(types + first, std::min(chunkModules_, size - first));
      }
      if (needsLinks) {
        index_.linkPart(types, firstChunk * chunkModules_, std::min(endChunk * chunkModules_, size), openEnds_[part]);
      }
    }
  });
  // then all together
  for (std::uint64_t chunk = 0; chunk < chunkCount; ++chunk) {
    chunkOffsets_[chunk + 1] += chunkOffsets_[chunk];
  }
  for (std::uint64_t part = 0; part < (needsLinks ? partCount : 0); ++part) {
    index_.joinPart(openEnds_[part], chunkOffsets_[part * kPartChunks]);
  }
}

std::uint64_t Derivation::Implementation::scanRound(const ModuleString& old, const BatchScan::Step& step,
                                                    std::uint64_t firstChunk) {
  const std::uint64_t size = step.old.size;
  ScanRound round(firstChunk, chunkOffsets_.size() - 1);
  std::mutex mutex;
  std::vector<std::uint64_t> unusual;  // chunks with values that the Evaluator must see
  round.modules = working_.size();
  round.parameters = working_.parameterCount();
  SharedOutput output(working_);

  team_->onEveryWorker([&](unsigned worker) {
    std::uint64_t chunk = 0;
    try {
      BatchScan& batch = *batches_[worker];
      batch.begin(step);
      while (round.take(chunk)) {
        const std::uint64_t first = chunk * chunkModules_;
        const BatchScan::Outcome outcome =
            batch.choose(first, std::min(first + chunkModules_, size), chunkOffsets_[chunk]);
        if (!round.awaitTurn(chunk)) {
          return;
        }
        const std::uint64_t modules = round.modules;
        const std::uint64_t parameterCount = round.parameters;
        round.modules += outcome.moduleCount;
        round.parameters += outcome.parameterCount;
        const bool isCancelled = options_.cancelled != nullptr && options_.cancelled->load(std::memory_order_relaxed);
        if (isCancelled || outcome.isUnusual || !isWithinLimits(round.modules, round.parameters) ||
            !output.holds(round.modules, round.parameters)) {
          round.modules = modules;
          round.parameters = parameterCount;
          round.stopAt(chunk);
          return;
        }
        // one thread at a time, in the order of the string
        if (outcome.isKept && !old.wereSet(chunkOffsets_[chunk], outcome.parameterCount)) {
          keptModules_.note(first, modules, outcome.moduleCount);
        }
        round.passTurn(chunk);
        output.prepare(modules, modules + outcome.moduleCount, parameterCount, parameterCount + outcome.parameterCount);
        if (!batch.write(output.types() + modules, output.parameters() + parameterCount)) {
          const std::lock_guard lock(mutex);
          unusual.push_back(chunk);
        }
      }
    } catch (...) {
      // the others must not wait for this chunk
      round.stopAt(chunk);
      throw;
    }
  });
  output.finish(round.modules, round.parameters);
  std::sort(unusual.begin(), unusual.end());
  unusualChunks_ = std::move(unusual);
  return round.end();
}

void Derivation::Implementation::scanInParallel(const PlantState& state) {
  const SystemTables& tables = tables_.front();
  const ModuleString& old = state.string;
  makeTeam();
  while (batches_.size() < threadCount_) {
    batches_.push_back(std::make_unique<BatchScan>(*program_, tables.rules, tables.batches, tables.plan));
  }
  findChunkOffsets(old, tables.batches.isFixedOnly() ? kFixedChunkModules : BatchScan::kChunkModules);
  BatchScan::Step step = batchStep(state);
  // each thread has its own
  step.old.shortcuts = nullptr;
  const std::uint64_t chunkCount = chunkOffsets_.size() - 1;
  const auto scanChunk = [&](std::uint64_t chunk) {
    evaluator_.clearModule();
    ScanPlace place{chunk * chunkModules_, chunkOffsets_[chunk]};
    scanUpTo(state, std::min(place.module + chunkModules_, old.size()), place);
  };
  for (std::uint64_t chunk = 0; chunk < chunkCount;) {
    chunk = scanRound(old, step, chunk);
    // values that fail or warn: in the order of the string, behind what is made already and dropped again
    for (const std::uint64_t unusual : unusualChunks_) {
      const std::uint64_t modules = working_.size();
      const std::uint64_t parameters = working_.parameterCount();
      scanChunk(unusual);
      working_.typeBuffer().resize(modules);
      working_.parameterBuffer().resize(parameters);
    }
    if (chunk < chunkCount) {
      evaluator_.clearModule();
      evaluator_.pollCancelled();
      scanChunk(chunk);
      rewriter_.checkSize(working_.size(), working_.parameterCount());
      ++chunk;
    }
  }
}

}  // namespace espalier::derivation

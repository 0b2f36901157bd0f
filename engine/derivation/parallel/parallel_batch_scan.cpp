#include "engine/derivation/parallel/parallel_batch_scan.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "engine/derivation/parallel/scan_round.h"
#include "engine/derivation/parallel/shared_output.h"
#include "engine/derivation/scan/batch_scan.h"

namespace espalier::derivation {
namespace {

// modules of a chunk that is only counted and written: long enough that threads seldom meet in one page
constexpr std::uint64_t kFixedChunkModules = 16 * BatchRewriter::kChunkModules;

}  // namespace

ParallelBatchScan::ParallelBatchScan(ScanContext& context, PlainScan& plain, core::WorkerTeam& team)
    : context_(&context), plain_(&plain), team_(&team), chunks_(context.program), shortcuts_(team.size()) {
  const SystemTables& tables = context.tables.front();
  for (unsigned worker = 0; worker < team.size(); ++worker) {
    batches_.push_back(std::make_unique<BatchRewriter>(context.program, tables.rules, tables.batches, tables.plan));
  }
}

void ParallelBatchScan::run(StringIndex* links) {
  ScanContext& context = *context_;
  const bool isFixedOnly = context.tables.front().batches.isFixedOnly();
  chunks_.cut(*context.old, isFixedOnly ? kFixedChunkModules : BatchRewriter::kChunkModules, *team_, links);
  const BatchRewriter::Step step = batchStep(context);
  for (SearchShortcuts& shortcuts : shortcuts_) {
    shortcuts.clear();
  }
  for (std::uint64_t chunk = 0; chunk < chunks_.count();) {
    chunk = runRound(step, chunk);
    // values that fail or warn: in the order of the string, behind the output and dropped again
    StepChanges* const changes = std::exchange(context.changes, nullptr);
    for (const std::uint64_t unusual : unusualChunks_) {
      const std::uint64_t modules = context.output.size();
      const std::uint64_t parameters = context.output.parameterCount();
      scanAlone(unusual);
      context.output.typeBuffer().resize(modules);
      context.output.parameterBuffer().resize(parameters);
    }
    context.changes = changes;
    stores_.apply(context.plant->statics);
    // the chunk that stopped the round
    if (chunk < chunks_.count()) {
      context.evaluator.clearModule();
      context.evaluator.pollCancelled();
      scanAlone(chunk);
      context.rewriter.checkSize(context.output.size(), context.output.parameterCount());
      ++chunk;
    }
  }
}

void ParallelBatchScan::scanAlone(std::uint64_t chunk) {
  context_->evaluator.clearModule();
  ScanPlace place = chunks_.begin(chunk);
  plain_->run(chunks_.begin(chunk + 1).module, place);
}

std::uint64_t ParallelBatchScan::runRound(const BatchRewriter::Step& step, std::uint64_t firstChunk) {
  ScanContext& context = *context_;
  ScanRound round(firstChunk, chunks_.count());
  std::mutex mutex;
  std::vector<std::uint64_t> unusual;
  round.modules = context.output.size();
  round.parameters = context.output.parameterCount();
  SharedOutput output(context.output);
  const bool hasBlocks = context.tables.front().batches.hasBlocks();
  stores_.clear();

  team_->onEveryWorker([&](unsigned worker) {
    std::uint64_t chunk = 0;
    try {
      BatchRewriter& batch = *batches_[worker];
      BatchRewriter::Step own = step;
      own.old.shortcuts = &shortcuts_[worker];
      batch.begin(own);
      while (round.take(chunk)) {
        const ScanPlace begin = chunks_.begin(chunk);
        const BatchRewriter::Outcome outcome =
            batch.choose(begin.module, chunks_.begin(chunk + 1).module, begin.offset);
        if (!round.awaitTurn(chunk)) {
          return;
        }
        const std::uint64_t modules = round.modules;
        const std::uint64_t parameters = round.parameters;
        const std::uint64_t endModules = modules + outcome.moduleCount;
        const std::uint64_t endParameters = parameters + outcome.parameterCount;
        if (context.isCancelled() || outcome.isUnusual || !context.isWithinLimits(endModules, endParameters) ||
            !output.holds(endModules, endParameters)) {
          round.stopAt(chunk);
          return;
        }
        round.modules = endModules;
        round.parameters = endParameters;
        // one thread at a time, in the order of the string
        if (context.changes != nullptr) {
          batch.noteKept(modules, *context.changes);
        }
        round.passTurn(chunk);
        output.prepare(modules, endModules, parameters, endParameters);
        const bool isUsual = batch.write(output.types() + modules, output.parameters() + parameters);
        if (!isUsual || hasBlocks) {
          const std::lock_guard lock(mutex);
          stores_.noteAll(batch.stores());
          if (!isUsual) {
            unusual.push_back(chunk);
          }
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

}  // namespace espalier::derivation

#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/worker_team.h"
#include "engine/derivation/batch/batch_rewriter.h"
#include "engine/derivation/parallel/string_chunks.h"
#include "engine/derivation/scan/plain_scan.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// Batches of a long string by several threads, for models in which batches can do every module
/// (BatchPlan::isComplete). Every thread has a BatchRewriter and writes its chunks into their place in the one output.
///
/// The threads take chunks in order. A thread chooses for its chunk, waits until the chunk before has said how long its
/// result is, says how long its own is, and writes. Waiting is short because counting never waits for writing. A chunk
/// that a batch cannot do stops the threads, and the calling thread does that chunk by the PlainScan. The string, the
/// first failure and the warnings are those of one thread, for any number of threads.
class ParallelBatchScan {
 public:
  /// All must outlive the object.
  ParallelBatchScan(ScanContext& context, PlainScan& plain, core::WorkerTeam& team);

  /// The whole old string. Links its brackets too, unless `links` is null.
  void run(StringIndex* links);

 private:
  std::uint64_t runRound(const BatchRewriter::Step& step, std::uint64_t firstChunk);
  void scanAlone(std::uint64_t chunk);

  ScanContext* context_;
  PlainScan* plain_;
  core::WorkerTeam* team_;
  StringChunks chunks_;
  std::vector<std::unique_ptr<BatchRewriter>> batches_;  // by worker
  std::vector<SearchShortcuts> shortcuts_;               // in the old string, by worker
  std::vector<std::uint64_t> unusualChunks_;  // of the last round: written, with values that fail or warn (ascending)
  LastStores stores_;                         // of the last round
};

}  // namespace espalier::derivation

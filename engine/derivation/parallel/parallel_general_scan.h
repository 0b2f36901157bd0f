#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/worker_team.h"
#include "engine/derivation/parallel/string_chunks.h"
#include "engine/derivation/scan/batch_scan.h"
#include "engine/derivation/scan/plain_scan.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// A long string by several threads, for models in which batches cannot do every module (predecessors of several
/// modules, the cut symbol, decomposition, draws anywhere) but no module depends on the rewriting of another
/// (SystemTables::isOrderFree). Every thread has a helper with a context and scans of its own.
///
/// The threads take chunks in order. A helper rewrites a chunk into a string of its own, which is copied into place in
/// the order of the chunks. A chunk stops the threads when an earlier chunk has reached into it, or when it failed,
/// warned or does not fit; the calling thread does that chunk by the PlainScan. The string, the first failure and the
/// warnings are those of one thread, for any number of threads.
class ParallelGeneralScan {
 public:
  /// All must outlive the object.
  ParallelGeneralScan(ScanContext& context, PlainScan& plain, core::WorkerTeam& team);
  ~ParallelGeneralScan();

  /// The whole old string. Links its brackets too, unless `links` is null.
  void run(StringIndex* links);

 private:
  class Helper;

  [[nodiscard]] ScanPlace chunkStart(std::uint64_t chunk) const;
  std::uint64_t runRound(std::uint64_t firstChunk, ScanPlace& place);

  ScanContext* context_;
  PlainScan* plain_;
  core::WorkerTeam* team_;
  StringChunks chunks_;
  std::vector<std::unique_ptr<Helper>> helpers_;  // by worker
};

}  // namespace espalier::derivation

#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clients/espalier/sweep/results.h"
#include "clients/espalier/sweep/run_table.h"
#include "clients/espalier/sweep/swept_model.h"

namespace espalier::command {

/// Runs that reached their end without a value of a measure.
struct MissingValues {
  std::uint64_t count = 0;
  std::uint64_t firstRun = 0;
};

/// How far a sweep has come.
struct SweepProgress {
  std::uint64_t done = 0;     // finished runs of the slice, those of earlier calls included
  std::uint64_t total = 0;    // runs of the slice
  std::uint64_t started = 0;  // finished before this call
  std::uint64_t failed = 0;   // runs of this call that did not reach their end
  std::uint64_t firstFailed = 0;
  std::string firstError;  // of run firstFailed
  std::uint64_t firstWarned = 0;
  std::string firstWarning;            // of run firstWarned; empty: the model and the measures gave no warning
  std::vector<MissingValues> missing;  // by column of the measures, of the runs of this call
  double seconds = 0.0;                // since the call
};

/// Makes all runs of the slice that `results` does not have, with `workers` threads. Rows are added in transactions of
/// about `secondsPerTransaction`. `progress` is called after each, from the calling thread. `isCancelled`, when it
/// becomes true, lets the runs that are going on finish. A sentence when results cannot be written.
[[nodiscard]] std::optional<std::string> runSweep(SweptModel& model, const RunTable& table, const Slice& slice,
                                                  unsigned workers, SweepResults& results, const PlantVisitor& visit,
                                                  const std::atomic<bool>& isCancelled,
                                                  const std::function<void(const SweepProgress&)>& progress,
                                                  SweepProgress& last);

/// Makes runs whose results stay in memory, with workers that keep what they have compiled.
class RunPool {
 public:
  RunPool(SweptModel& model, unsigned workers);
  /// The outcomes of all rows of the table, in their order.
  [[nodiscard]] std::vector<RunOutcome> run(const RunTable& table);

 private:
  std::vector<std::unique_ptr<ModelRunner>> runners_;
};

}  // namespace espalier::command

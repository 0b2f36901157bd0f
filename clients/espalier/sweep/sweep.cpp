#include "clients/espalier/sweep/sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace espalier::command {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTransaction{500};
// finished rows that wait for the disk; workers then wait too
constexpr std::size_t kMostWaiting = 50'000;

/// Finished rows on their way from the workers to the file.
class FinishedRows {
 public:
  void add(ResultRow row) {
    std::unique_lock lock(mutex_);
    taken_.wait(lock, [this] { return rows_.size() < kMostWaiting; });
    rows_.push_back(std::move(row));
    if (rows_.size() >= kMostWaiting) {
      added_.notify_one();
    }
  }
  void workerEnds() {
    const std::scoped_lock lock(mutex_);
    ++ended_;
    added_.notify_one();
  }
  /// Waits until `deadline` or until all workers have ended, and takes the rows. True: the workers have ended.
  bool take(Clock::time_point deadline, std::size_t workers, std::vector<ResultRow>& rows) {
    std::unique_lock lock(mutex_);
    added_.wait_until(lock, deadline, [&] { return ended_ == workers || rows_.size() >= kMostWaiting; });
    rows.swap(rows_);
    rows_.clear();
    taken_.notify_all();
    return ended_ == workers;
  }

 private:
  std::mutex mutex_;
  std::condition_variable added_;
  std::condition_variable taken_;
  std::vector<ResultRow> rows_;
  std::size_t ended_ = 0;
};

}  // namespace

std::optional<std::string> runSweep(SweptModel& model, const RunTable& table, const Slice& slice, unsigned workers,
                                    SweepResults& results, const PlantVisitor& visit,
                                    const std::atomic<bool>& isCancelled,
                                    const std::function<void(const SweepProgress&)>& progress, SweepProgress& last) {
  const auto begin = Clock::now();
  const Result<std::vector<bool>> finished = results.finishedRuns();
  if (!finished) {
    return finished.error();
  }
  std::vector<std::uint64_t> missing;
  for (std::uint64_t run = 1; run <= table.count(); ++run) {
    if (slice.has(run)) {
      ++last.total;
      (*finished)[run] ? static_cast<void>(++last.done) : missing.push_back(run);
    }
  }
  last.started = last.done;
  last.missing.resize(model.measureColumns().size());

  std::atomic<std::size_t> next{0};
  std::atomic<bool> hasFailed{false};
  FinishedRows rows;
  const auto work = [&] {
    ModelRunner runner(model);
    while (!isCancelled && !hasFailed) {
      const std::size_t place = next++;
      if (place >= missing.size()) {
        break;
      }
      const std::uint64_t run = missing[place];
      const std::span<const double> row = table.row(run - 1);
      rows.add({.run = run,
                .seed = table.seeds[run - 1],
                .parameters = {row.begin(), row.end()},
                .outcome = runner.run(row, table.seeds[run - 1], run, visit)});
    }
    rows.workerEnds();
  };
  const auto count = static_cast<unsigned>(std::clamp<std::size_t>(missing.size(), 1, std::max(workers, 1U)));
  std::vector<std::jthread> threads;
  for (unsigned i = 0; i < count; ++i) {
    threads.emplace_back(work);
  }
  std::optional<std::string> problem;
  std::vector<ResultRow> batch;
  for (bool isOver = false; !isOver;) {
    isOver = rows.take(Clock::now() + kTransaction, count, batch);
    if (problem) {
      continue;  // the workers end with the runs that they have begun
    }
    if (!batch.empty()) {
      problem = results.add(batch);
      hasFailed = problem.has_value();
    }
    for (const ResultRow& row : batch) {
      if (!row.outcome.warning.empty() && (last.firstWarning.empty() || row.run < last.firstWarned)) {
        last.firstWarned = row.run;
        last.firstWarning = row.outcome.warning;
      }
      if (!row.outcome.error.empty()) {
        if (last.failed++ == 0 || row.run < last.firstFailed) {
          last.firstFailed = row.run;
          last.firstError = row.outcome.error;
        }
        continue;
      }
      for (std::size_t i = 0; i < last.missing.size(); ++i) {
        MissingValues& empty = last.missing[i];
        if (std::isnan(row.outcome.values[i]) && (empty.count++ == 0 || row.run < empty.firstRun)) {
          empty.firstRun = row.run;
        }
      }
    }
    last.done += problem ? 0 : batch.size();
    last.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    progress(last);
  }
  return problem;
}

RunPool::RunPool(SweptModel& model, unsigned workers) {
  for (unsigned i = 0; i < std::max(workers, 1U); ++i) {
    runners_.push_back(std::make_unique<ModelRunner>(model));
  }
}

std::vector<RunOutcome> RunPool::run(const RunTable& table) {
  std::vector<RunOutcome> outcomes(table.count());
  std::atomic<std::size_t> next{0};
  const auto work = [&](ModelRunner& runner) {
    for (std::size_t i = next++; i < outcomes.size(); i = next++) {
      outcomes[i] = runner.run(table.row(i), table.seeds[i], i + 1, {});
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (std::size_t i = 1; i < std::min(runners_.size(), outcomes.size()); ++i) {
      helpers.emplace_back([&work, this, i] { work(*runners_[i]); });
    }
    work(*runners_.front());
  }
  return outcomes;
}

}  // namespace espalier::command

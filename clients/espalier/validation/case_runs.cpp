#include "clients/espalier/validation/case_runs.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <ctime>
#include <mutex>
#include <span>

#include "clients/espalier/validation/reference_table.h"
#include "engine/core/worker_team.h"

namespace espalier::validation {

namespace {

double processorSecondsOfThread() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double processorSecondsOfProgram() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Runs a case, with the processor time that `processorSeconds` counts.
void runCase(Run& run, const Data& data, double (*processorSeconds)()) {
  const auto begin = std::chrono::steady_clock::now();
  const double processorBegin = processorSeconds();
  try {
    run.result = run.one->run(data);
  } catch (const TableError& error) {
    run.tableError = error.what();
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  run.took = {seconds.count(), processorSeconds() - processorBegin};
}

/// Runs quick cases beside each other.
bool runQuickCases(std::span<Run> runs, const Data& data, unsigned threads,
                   const std::function<bool(const Run&)>& report) {
  std::mutex mutex;
  std::vector<bool> hasRun(runs.size(), false);
  std::size_t next = 0;  // the first that is not reported
  bool isGood = true;
  core::WorkerTeam team(static_cast<unsigned>(std::clamp<std::size_t>(threads, 1, runs.size())));
  team.forEach(runs.size(), [&](std::size_t i) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      if (!isGood) {
        return;
      }
    }
    runCase(runs[i], data, processorSecondsOfThread);
    const std::lock_guard<std::mutex> lock(mutex);
    hasRun[i] = true;
    for (; isGood && next < runs.size() && hasRun[next]; ++next) {
      isGood = report(runs[next]);
    }
  });
  return isGood;
}

}  // namespace

bool runCases(const std::vector<const Case*>& chosen, const Data& data, unsigned threads,
              const std::function<bool(const Run&)>& report) {
  std::vector<Run> runs;
  for (const Case* one : chosen) {
    runs.push_back({one, {}, {}, {}});
  }
  std::span<Run> left(runs);
  while (!left.empty()) {
    const auto firstLong = std::find_if(left.begin(), left.end(), [](const Run& run) { return !run.one->isQuick; });
    const auto quick = static_cast<std::size_t>(firstLong - left.begin());
    if (quick > 0) {
      if (!runQuickCases(left.first(quick), data, threads, report)) {
        return false;
      }
    } else {
      runCase(left.front(), data, processorSecondsOfProgram);
      if (!report(left.front())) {
        return false;
      }
    }
    left = left.subspan(std::max<std::size_t>(quick, 1));
  }
  return true;
}

}  // namespace espalier::validation

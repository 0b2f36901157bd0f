// Sweeps beside a bare loop over the same runs: what the table, the measures and the file of results cost.

#include <benchmark/benchmark.h>

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/sweep/sweep.h"
#include "tests/benchmark/workload.h"
#include "tests/support/disk_files.h"
#include "tests/support/model_environment.h"
#include "tests/support/places.h"

namespace espalier::benchmarking {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kRuns = 2000;

std::string modelFile(const char* suffix) {
  return sourceFolder() + "/clients/gallery/branch-tiers/branch-tiers" + suffix;
}

// the environment of branch-tiers: honda, by its published file
std::unique_ptr<turtle::EnvironmentProcess> honda() {
  test::DiskFiles files;
  return test::environmentBeside(modelFile(".l"), files);
}

/// Time since the object was made.
class Stopwatch {
 public:
  /// Seconds of the clock, and of the processor by all threads: the second do not grow when other programs run.
  struct Times {
    double wall;
    double processor;
  };
  [[nodiscard]] Times elapsed() const {
    return {std::chrono::duration<double>(Clock::now() - begin_).count(),
            static_cast<double>(std::clock() - processorBegin_) / CLOCKS_PER_SEC};
  }

 private:
  Clock::time_point begin_ = Clock::now();
  std::clock_t processorBegin_ = std::clock();
};
using Times = Stopwatch::Times;

// the runs without a sweep: one simulation that is set back for each run
Times bareLoop(const std::shared_ptr<const language::Program>& program, const command::RunTable& table,
               std::uint64_t& modules) {
  simulation::Simulation simulation(program, {turtle::PlantPlacement{}}, honda(), {});
  const Stopwatch watch;
  for (const std::uint64_t seed : table.seeds) {
    require(simulation.rewind(seed));
    while (!simulation.isFinished()) {
      require(simulation.step());
    }
    modules = simulation.string().size();
  }
  return watch.elapsed();
}

Times sweep(command::SweptModel& model, const command::RunTable& table) {
  const std::string file =
      (fs::temp_directory_path() / ("espalier-sweep-" + std::to_string(getpid()) + ".sqlite")).string();
  const Stopwatch watch;
  {
    auto results = command::SweepResults::continued(file, command::describeSweep(model, table));
    const std::atomic<bool> isCancelled{false};
    command::SweepProgress last;
    const auto problem = command::runSweep(
        model, table, {}, 1, *results, {}, isCancelled, [](const command::SweepProgress&) {}, last);
    if (problem || last.failed > 0) {
      throw std::runtime_error(problem.value_or(last.firstError));
    }
  }
  const Times taken = watch.elapsed();
  for (const char* suffix : {"", "-wal", "-shm"}) {
    fs::remove(file + suffix);
  }
  return taken;
}

void runs(benchmark::State& state) {
  test::DiskFiles files;
  const auto program = compileFile(modelFile(".l"), modelFile(".v"), {});
  command::SweepInput input;
  input.plan = *command::readPlan("{\"model\":\"branch-tiers\",\"replicates\":" + std::to_string(kRuns) +
                                  ",\"measures\":{\"modules\":{\"count\":\"*\"},\"tips\":{\"count\":\"A\"}}}");
  input.model.modelFile = modelFile(".l");
  input.model.viewFile = modelFile(".v");
  input.environmentMaker = honda;
  auto table = command::makeRuns(input.plan, "", files);
  auto model = command::SweptModel::make(std::move(input), {}, files);
  if (!model || !table) {
    throw std::runtime_error(model ? table.error() : model.error());
  }
  std::vector<Times> bare;
  std::vector<Times> swept;
  std::uint64_t modules = 0;
  for (auto _ : state) {
    // in turn, so that a busy machine slows both
    bare.push_back(bareLoop(program, *table, modules));
    swept.push_back(sweep(**model, *table));
  }
  const auto median = [](const std::vector<Times>& all, double Times::*clock) {
    std::vector<double> times;
    for (const Times& one : all) {
      times.push_back(one.*clock);
    }
    std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
    return times[times.size() / 2];
  };
  const double time = median(swept, &Times::wall);
  state.counters["modules"] = benchmark::Counter(static_cast<double>(modules));
  state.counters["runs/s"] = benchmark::Counter(kRuns / time);
  state.counters["of a bare loop"] = benchmark::Counter(time / median(bare, &Times::wall));
  state.counters["of its processor time"] =
      benchmark::Counter(median(swept, &Times::processor) / median(bare, &Times::processor));
  // of 10^5 runs by two workers, extrapolated
  state.counters["minutes for 100000"] = benchmark::Counter(1e5 / kRuns * time / 2.0 / 60.0);
}

BENCHMARK(runs)->Name("sweep/branch-tiers")->Unit(benchmark::kMillisecond)->Iterations(5);

}  // namespace
}  // namespace espalier::benchmarking

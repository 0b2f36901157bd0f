// Derivation alone, the work of README.md: all steps of a model from its axiom, allocation included.

#include <benchmark/benchmark.h>

#include "tests/benchmark/workload.h"

namespace espalier::benchmarking {
namespace {

// modules and bytes of all strings that a run writes
struct Totals {
  std::uint64_t scannedModules = 0;
  std::uint64_t writtenBytes = 0;
};

Totals runAll(simulation::Simulation& simulation) {
  Totals totals;
  require(simulation.rewind());
  while (!simulation.isFinished()) {
    totals.scannedModules += simulation.string().size();
    require(simulation.step());
    totals.writtenBytes += simulation.string().bytes();
  }
  return totals;
}

void derive(benchmark::State& state, const Workload& workload) {
  const auto program = compileWorkload(workload);
  simulation::SimulationOptions options;
  options.threads = workload.threads;
  Totals totals;
  std::uint64_t modules = 0;
  std::uint64_t bytes = 0;
  for (auto _ : state) {
    // a new simulation each time: a run pays for its memory
    simulation::Simulation simulation(program, {turtle::PlantPlacement{}}, nullptr, options);
    totals = runAll(simulation);
    modules = simulation.string().size();
    bytes = simulation.string().bytes();
    benchmark::DoNotOptimize(modules);
  }
  using Counter = benchmark::Counter;
  const auto rate = [](std::uint64_t count) {
    return Counter(static_cast<double>(count), Counter::kIsIterationInvariantRate);
  };
  state.counters["modules"] = Counter(static_cast<double>(modules));
  state.counters["modules/s"] = rate(modules);
  state.counters["scanned/s"] = rate(totals.scannedModules);
  state.counters["bytes/module"] = Counter(static_cast<double>(bytes) / static_cast<double>(modules));
  // times a plain copy of all bytes that were written
  state.counters["copies"] =
      Counter(secondsToCopy(totals.writtenBytes), Counter::kIsIterationInvariantRate | Counter::kInvert);
}

void addDerivation(const Workload& workload) {
  const std::string threads = workload.threads == 1 ? "" : "/threads:" + std::to_string(workload.threads);
  benchmark::RegisterBenchmark(("derive/" + workload.model + "/" + workload.steps + threads).c_str(),
                               [workload](benchmark::State& state) { derive(state, workload); })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}

const bool kIsRegistered = [] {
  for (const Workload& workload :
       {Workload{"d0l", "11"}, Workload{"parametric", "20"}, Workload{"parametric", "22"}, Workload{"signal-up", "123"},
        Workload{"diffusion", "123"}, Workload{"signal-down", "123"}, Workload{"stochastic", "13"}}) {
    addDerivation(workload);
  }
  addDerivation({"parametric", "22", 2});
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

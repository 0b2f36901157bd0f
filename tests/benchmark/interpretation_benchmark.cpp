// The turtle alone: a grown string to a scene, and to records of the turtle stream.

#include <benchmark/benchmark.h>

#include "tests/benchmark/workload.h"

namespace espalier::benchmarking {
namespace {

using benchmark::Counter;

enum class Product { Scene, Records };

void interpret(benchmark::State& state, const Workload& workload, Product product, unsigned threads) {
  simulation::SimulationOptions options;
  options.threads = threads;
  simulation::Simulation simulation(compileWorkload(workload), {turtle::PlantPlacement{}}, nullptr, options);
  require(simulation.rewind());
  while (!simulation.isFinished()) {
    require(simulation.step());
  }
  std::size_t segments = 0;
  for (auto _ : state) {
    if (product == Product::Scene) {
      auto drawn = simulation.scene();
      segments = drawn.value().segments.size();
      benchmark::DoNotOptimize(drawn);
    } else {
      benchmark::DoNotOptimize(simulation.turtleRecords());
    }
  }
  const auto modules = static_cast<double>(simulation.string().size());
  state.counters["modules"] = Counter(modules);
  state.counters["modules/s"] = Counter(modules, Counter::kIsIterationInvariantRate);
  if (segments > 0) {
    state.counters["segments/s"] = Counter(static_cast<double>(segments), Counter::kIsIterationInvariantRate);
    state.counters["scene"] = Counter(static_cast<double>(segments * sizeof(turtle::Segment)));
  }
}

void add(const std::string& name, const Workload& workload, Product product, unsigned threads = 1) {
  benchmark::RegisterBenchmark((name + workload.name() + (threads > 1 ? "/" + std::to_string(threads) : "")).c_str(),
                               [=](benchmark::State& state) { interpret(state, workload, product, threads); })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}

const bool kIsRegistered = [] {
  // lines in a plane, lines in space with widths, images of a homomorphism
  add("scene/", {"d0l", "8", ""}, Product::Scene);
  add("scene/", {"parametric", "17", ""}, Product::Scene);
  // nearly five million modules in a plane, more than five million in space
  add("scene/", {"d0l", "9", ""}, Product::Scene);
  add("scene/", {"parametric", "19", ""}, Product::Scene);
  add("scene/", {"homomorphism", "16", ""}, Product::Scene);
  // by two threads: lines of the string, and of images
  add("scene/", {"parametric", "19", ""}, Product::Scene, 2);
  add("scene/", {"drawn-twigs", "17", ""}, Product::Scene);
  add("scene/", {"drawn-twigs", "17", ""}, Product::Scene, 2);
  add("records/", {"parametric", "17", ""}, Product::Records);
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

// The gallery's models as `espalier run` makes them, with environment and world: all steps, then the picture's scene.

#include <benchmark/benchmark.h>

#include <filesystem>

#include "tests/benchmark/gallery_model.h"
#include "tests/benchmark/workload.h"

namespace espalier::benchmarking {
namespace {

namespace fs = std::filesystem;

void grow(benchmark::State& state, const fs::path& model) {
  fs::path view = model;
  view.replace_extension(".v");
  const auto program = compileFile(model.string(), fs::exists(view) ? view.string() : "", {});
  simulation::Simulation simulation = simulationOf(program, model.string());
  require(simulation.rewind());
  core::StringSink axiom;
  simulation.save(axiom);
  std::uint64_t queries = 0;
  for (auto _ : state) {
    state.PauseTiming();
    require(simulation.restore(axiom.text()));
    queries = 0;
    state.ResumeTiming();
    while (!simulation.isFinished()) {
      require(simulation.step());
      queries += simulation.statistics().queries;
    }
    benchmark::DoNotOptimize(simulation.scene());
  }
  const auto modules = static_cast<double>(simulation.string().size());
  state.counters["modules"] = benchmark::Counter(modules);
  state.counters["modules/s"] = benchmark::Counter(modules, benchmark::Counter::kIsIterationInvariantRate);
  if (queries > 0) {
    state.counters["queries/s"] =
        benchmark::Counter(static_cast<double>(queries), benchmark::Counter::kIsIterationInvariantRate);
  }
}

const bool kIsRegistered = [] {
  for (const fs::path model : galleryModels()) {
    benchmark::RegisterBenchmark(("gallery/" + model.stem().string()).c_str(),
                                 [model](benchmark::State& state) { grow(state, model); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

BENCHMARK_MAIN();

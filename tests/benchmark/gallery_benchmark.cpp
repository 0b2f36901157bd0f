// The gallery's models with the environments that `espalier run` attaches: all steps, then the picture's scene.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <filesystem>

#include "tests/benchmark/workload.h"
#include "tests/support/disk_files.h"
#include "tests/support/model_environment.h"
#include "tests/support/places.h"

namespace espalier::benchmarking {
namespace {

namespace fs = std::filesystem;

void grow(benchmark::State& state, const fs::path& model) {
  fs::path view = model;
  view.replace_extension(".v");
  const auto program = compileFile(model.string(), fs::exists(view) ? view.string() : "", {});
  test::DiskFiles files;
  simulation::Simulation simulation(program, {turtle::PlantPlacement{}},
                                    test::environmentBeside(model.string(), files), {});
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
  std::vector<fs::path> models;
  std::error_code error;
  for (const auto& folder : fs::directory_iterator(sourceFolder() + "/clients/gallery", error)) {
    const fs::path model = folder.path() / (folder.path().filename().string() + ".l");
    if (fs::exists(model)) {
      models.push_back(model);
    }
  }
  std::sort(models.begin(), models.end());
  for (const fs::path& model : models) {
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

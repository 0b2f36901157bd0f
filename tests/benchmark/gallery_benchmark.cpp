// The gallery's models that need no environment or one that its `.e` file names: all steps, then the picture's scene.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <filesystem>

#include "environment/published/published_environment.h"
#include "tests/benchmark/workload.h"
#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::benchmarking {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<turtle::EnvironmentProcess> fieldEnvironment(const fs::path& model) {
  fs::path file = model;
  file.replace_extension(".e");
  if (!fs::exists(file)) {
    return nullptr;
  }
  test::DiskFiles files;
  std::vector<core::Diagnostic> warnings;
  auto made = environment::makeFromEnvironmentFile(file.string(), files, core::Compatibility::Espalier, warnings);
  if (!made) {
    throw std::runtime_error(made.error().front().message);
  }
  return std::move(*made);
}

void grow(benchmark::State& state, const fs::path& model) {
  fs::path view = model;
  view.replace_extension(".v");
  const auto program = compileFile(model.string(), fs::exists(view) ? view.string() : "", {});
  simulation::Simulation simulation(program, {turtle::PlantPlacement{}}, fieldEnvironment(model), {});
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

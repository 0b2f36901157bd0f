// Models as modellers write them, whole: derivation, environment, interpretation and writing, each with its share. The
// gallery's models, and one model of each class of `models/` that other programs are compared by.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "engine/derivation/state/string_text.h"
#include "tests/benchmark/gallery_model.h"
#include "tests/benchmark/workload.h"
#include "tests/support/places.h"

namespace espalier::benchmarking {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Milliseconds of the parts of a run.
struct Parts {
  double derivation = 0.0;
  double environment = 0.0;
  double interpretation = 0.0;
  double writing = 0.0;
};

template <typename F>
void timed(double& milliseconds, F work) {
  const auto start = Clock::now();
  work();
  milliseconds += std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

void runWhole(benchmark::State& state, const std::shared_ptr<const language::Program>& program, const fs::path& model) {
  Parts parts;
  double scannedModules = 0.0;
  double modules = 0.0;
  for (auto _ : state) {
    simulation::Simulation simulation = simulationOf(program, model.string());
    require(simulation.rewind());
    while (!simulation.isFinished()) {
      scannedModules += static_cast<double>(simulation.string().size());
      timed(parts.environment, [&] { require(simulation.answer()); });
      timed(parts.derivation, [&] { require(simulation.step()); });
    }
    timed(parts.interpretation, [&] { benchmark::DoNotOptimize(simulation.scene()); });
    timed(parts.writing, [&] {
      benchmark::DoNotOptimize(derivation::toText(*program, simulation.string(), core::NumberStyle::Shortest));
    });
    modules = static_cast<double>(simulation.string().size());
  }
  const auto perRun = [](double value) { return benchmark::Counter(value, benchmark::Counter::kAvgIterations); };
  state.counters["modules"] = benchmark::Counter(modules);
  state.counters["derivation ms"] = perRun(parts.derivation);
  state.counters["environment ms"] = perRun(parts.environment);
  state.counters["interpretation ms"] = perRun(parts.interpretation);
  state.counters["writing ms"] = perRun(parts.writing);
  state.counters["ns/module"] = benchmark::Counter(parts.derivation * 1e6 / std::max(scannedModules, 1.0));
}

void add(const std::string& name, const fs::path& model, const Defines& defines) {
  benchmark::RegisterBenchmark(
      ("field-models/" + name).c_str(),
      [model, defines](benchmark::State& state) {
        fs::path view = model;
        view.replace_extension(".v");
        runWhole(state, compileFile(model.string(), fs::exists(view) ? view.string() : "", defines), model);
      })
      ->Unit(benchmark::kMillisecond)
      ->MinTime(1.0)  // the first run of a large model also pays for pages that the process has not had yet
      ->UseRealTime();
}

const bool kIsRegistered = [] {
  for (const Workload& workload :
       {Workload{"blocks", "20", ""}, Workload{"accounts", "40", "15"}, Workload{"globals", "60", "14"},
        Workload{"neighbours", "30", "11"}, Workload{"candidates", "60", "14"}, Workload{"decomposition", "60", "12"},
        Workload{"cuts", "30", "12"}, Workload{"pairs", "60", "16"}, Workload{"arrays", "60", "14"},
        Workload{"assigned", "60", "14"}, Workload{"counters", "60", "14"}, Workload{"functions", "60", "13"},
        Workload{"answers", "60", "13"}}) {
    Defines defines{{"N", workload.steps}};
    if (!workload.size.empty()) {
      defines.emplace_back("K", workload.size);
    }
    add(workload.name(), sourceFolder() + "/tests/benchmark/models/" + workload.model + ".l", defines);
  }
  for (const fs::path model : galleryModels()) {
    add(model.stem().string(), model, {});
  }
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

// Meshing, pictures and mesh files of a grown tree of 40 thousand and of 5 million modules.

#include <benchmark/benchmark.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/mesh/placed_meshes.h"
#include "engine/turtle/export/picture/picture.h"
#include "tests/benchmark/workload.h"

namespace espalier::benchmarking {
namespace {

/// Counts what is written and keeps nothing: a disk of any speed would hide the writer.
class CountingSink final : public core::ByteSink {
 public:
  void write(std::string_view bytes) override { count_ += bytes.size(); }
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  std::uint64_t count_ = 0;
};

// a figure of this process in bytes, 0 where the system does not tell
double statusBytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name)) {
      return std::strtod(line.c_str() + name.size(), nullptr) * 1024.0;
    }
  }
  return 0.0;
}

// memory held now; the largest that is held from now on counts as `VmHWM:`
double beginMeasuringMemory() {
  std::ofstream("/proc/self/clear_refs") << "5";
  return statusBytes("VmRSS:");
}

struct GrownTree {
  std::shared_ptr<const language::Program> program;
  turtle::Scene scene;
  std::uint64_t modules = 0;
};

GrownTree grow(const Workload& workload) {
  GrownTree tree;
  tree.program = compileWorkload(workload);
  simulation::Simulation simulation(tree.program, {turtle::PlantPlacement{}}, nullptr, {});
  require(simulation.rewind());
  while (!simulation.isFinished()) {
    require(simulation.step());
  }
  tree.modules = simulation.string().size();
  auto drawn = simulation.scene();
  tree.scene = std::move(drawn.value());
  return tree;
}

void count(benchmark::State& state, const GrownTree& tree, std::uint64_t triangles) {
  using benchmark::Counter;
  state.counters["modules"] = Counter(static_cast<double>(tree.modules));
  state.counters["segments/s"] =
      Counter(static_cast<double>(tree.scene.segments.size()), Counter::kIsIterationInvariantRate);
  if (triangles > 0) {
    state.counters["triangles/s"] = Counter(static_cast<double>(triangles), Counter::kIsIterationInvariantRate);
  }
}

// all meshes of a scene, by so many threads, handed over in order
void meshing(benchmark::State& state, const Workload& workload, unsigned threads) {
  const GrownTree tree = grow(workload);
  std::uint64_t triangles = 0;
  const double before = beginMeasuringMemory();
  for (auto _ : state) {
    triangles = 0;
    const turtle::ExportInput input{.scene = tree.scene, .view = tree.program->view, .threads = threads};
    const turtle::ScenePlacement here;
    turtle::PlacedMeshes meshes({{&input, 1}, {&here, 1}});
    const auto problem = meshes.forEach(
        [&triangles](const turtle::PlacedMeshes::Item&, const turtle::Mesh& mesh) -> std::optional<std::string> {
          triangles += mesh.triangleCount();
          return std::nullopt;
        });
    if (problem) {
      state.SkipWithError(problem->c_str());
      return;
    }
  }
  count(state, tree, triangles);
  state.counters["more memory"] = benchmark::Counter(statusBytes("VmHWM:") - before);
}

// a picture of points of 1600 by 1200, without its compression
void drawing(benchmark::State& state, const Workload& workload, unsigned threads) {
  GrownTree tree = grow(workload);
  tree.scene.lineStyle = files::LineStyle::Cylinder;
  const turtle::PictureOptions options{.widthPixels = 1600, .heightPixels = 1200, .threads = threads};
  const double before = beginMeasuringMemory();
  for (auto _ : state) {
    benchmark::DoNotOptimize(turtle::renderPicture(tree.scene, tree.program->view, options));
  }
  count(state, tree, 0);
  state.counters["more memory"] = benchmark::Counter(statusBytes("VmHWM:") - before);
}

// a file of them; `scene` is the memory of its segments, `more memory` what writing needed beside
void writing(benchmark::State& state, const Workload& workload, const turtle::ExportFormat& format) {
  const GrownTree tree = grow(workload);
  std::uint64_t bytes = 0;
  const double before = beginMeasuringMemory();
  for (auto _ : state) {
    CountingSink sink;
    CountingSink companion;
    const turtle::ExportTarget target{.fileName = "tree",
                                      .sink = sink,
                                      .openCompanion = [&](const std::string&) -> core::ByteSink& { return companion; },
                                      .progress = {}};
    if (const auto problem = format.write({.scene = tree.scene, .view = tree.program->view}, target)) {
      state.SkipWithError(problem->c_str());
      return;
    }
    bytes = sink.count();
  }
  count(state, tree, 0);
  state.counters["file"] = benchmark::Counter(static_cast<double>(bytes));
  state.counters["bytes/s"] =
      benchmark::Counter(static_cast<double>(bytes), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["scene"] =
      benchmark::Counter(static_cast<double>(tree.scene.segments.size() * sizeof(turtle::Segment)));
  state.counters["more memory"] = benchmark::Counter(statusBytes("VmHWM:") - before);
}

const bool kIsRegistered = [] {
  // a picture file of about a million triangles
  const Workload million{"parametric", "15", ""};
  benchmark::RegisterBenchmark(
      ("write/png/" + million.name()).c_str(),
      [million](benchmark::State& state) { writing(state, million, *turtle::findExportFormat("png")); })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
  for (const char* steps : {"12", "19"}) {
    const Workload workload{"parametric", steps, ""};
    for (const unsigned threads : {1U, 2U}) {
      const std::string behind = workload.name() + "/threads:" + std::to_string(threads);
      benchmark::RegisterBenchmark(("mesh/" + behind).c_str(),
                                   [workload, threads](benchmark::State& state) { meshing(state, workload, threads); })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
      benchmark::RegisterBenchmark(("draw/" + behind).c_str(),
                                   [workload, threads](benchmark::State& state) { drawing(state, workload, threads); })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    }
    for (const char* name : {"glb", "obj", "ply", "stl", "usda"}) {
      const turtle::ExportFormat& format = *turtle::findExportFormat(name);
      benchmark::RegisterBenchmark((std::string("write/") + name + "/" + workload.name()).c_str(),
                                   [workload, &format](benchmark::State& state) { writing(state, workload, format); })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    }
  }
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

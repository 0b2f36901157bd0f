// The other half of a step: interpretation for queries, answers, and writing them back; and the processes alone.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "tests/benchmark/workload.h"

namespace espalier::benchmarking {
namespace {

using Counter = benchmark::Counter;
using Process = std::unique_ptr<turtle::EnvironmentProcess>;
using Clock = std::chrono::steady_clock;

// the environment part of a model over the twenty steps from the first one on: `environmentMilliseconds` of
// `espalier derive --environment PROCESS --statistics`
void answerSteps(benchmark::State& state, const std::string& model, std::uint64_t firstStep, const std::string& name,
                 unsigned threads) {
  const auto program = compileWorkload({model, std::to_string(firstStep + 19), ""});
  simulation::SimulationOptions options;
  options.threads = threads;
  std::uint64_t queries = 0;
  double best = 1e30;
  double bestCopy = 1e30;
  std::vector<std::uint64_t> stringBytes;  // of the strings that are interpreted
  std::uint64_t modules = 0;               // of the last one
  for (auto _ : state) {
    simulation::Simulation simulation(program, {turtle::PlantPlacement{}}, makeProcess(name, ""), options);
    require(simulation.rewind());
    double seconds = 0.0;
    queries = 0;
    stringBytes.clear();
    while (!simulation.isFinished()) {
      const auto start = Clock::now();
      require(simulation.answer());
      if (simulation.completedSteps() + 1 >= firstStep) {
        seconds += std::chrono::duration<double>(Clock::now() - start).count();
        queries += simulation.statistics().queries;
        stringBytes.push_back(simulation.string().bytes());
        modules = simulation.string().size();
      }
      require(simulation.step());
    }
    state.SetIterationTime(seconds);
    best = std::min(best, seconds);
    bestCopy = std::min(bestCopy, secondsToCopy(stringBytes, threads));
  }
  const auto bytes = static_cast<double>(std::accumulate(stringBytes.begin(), stringBytes.end(), std::uint64_t{0}));
  state.counters["best ms"] = Counter(best * 1e3);
  state.counters["ms/step"] = Counter(best * 1e3 / 20.0);
  state.counters["queries"] = Counter(static_cast<double>(queries));
  state.counters["queries/s"] = Counter(static_cast<double>(queries) / best);
  state.counters["written bytes/s"] = Counter(bytes / best);
  state.counters["copied bytes/s"] = Counter(bytes / bestCopy);
  state.counters["bytes/module"] = Counter(static_cast<double>(stringBytes.back()) / static_cast<double>(modules));
}

// 65,536 queries a step (README.md: open.l with K=16, grown after 16 steps)
void answer(benchmark::State& state, const std::string& name, const std::string& configuration) {
  const auto program = compileWorkload({"open", "40", ""});
  simulation::Simulation simulation(program, {turtle::PlantPlacement{}}, makeProcess(name, configuration), {});
  require(simulation.rewind());
  while (simulation.completedSteps() < 18) {
    require(simulation.step());
  }
  core::StringSink grown;
  simulation.save(grown);
  std::uint64_t queries = 0;
  for (auto _ : state) {
    state.PauseTiming();
    require(simulation.restore(grown.text()));
    state.ResumeTiming();
    require(simulation.answer());
    queries = simulation.statistics().queries;
  }
  state.counters["queries"] = Counter(static_cast<double>(queries));
  state.counters["queries/s"] = Counter(static_cast<double>(queries), Counter::kIsIterationInvariantRate);
}

// the parameters of query i in the benchmark of one process
using Parameters = std::vector<double> (*)(std::size_t i);

// queries at points of a space-filling lattice (R3 sequence), about one per unit of volume
turtle::QueryBatch makeQueries(std::size_t count, Parameters parametersOf) {
  turtle::QueryBatch batch;
  const double side = std::cbrt(static_cast<double>(count));
  constexpr double kGolden = 1.2207440846057596;
  batch.parameterOffset.push_back(0);
  batch.followingOffset.push_back(0);
  for (std::size_t i = 0; i < count; ++i) {
    const auto coordinate = [&](double power) {
      const double x = static_cast<double>(i + 1) / std::pow(kGolden, power);
      return side * (x - std::floor(x));
    };
    // four plants that grow through each other
    batch.plant.push_back(static_cast<std::uint32_t>(4 * i / count));
    batch.module.push_back(i);
    batch.symbol.push_back(0);
    batch.isTransient.push_back(0);
    batch.position.push_back({coordinate(1.0), coordinate(2.0), coordinate(3.0)});
    batch.heading.push_back({0.0, 1.0, 0.0});
    batch.left.push_back({-1.0, 0.0, 0.0});
    batch.up.push_back({0.0, 0.0, -1.0});
    batch.width.push_back(1.0);
    batch.scale.push_back(1.0);
    const std::vector<double> parameters = parametersOf(i);
    batch.parameters.insert(batch.parameters.end(), parameters.begin(), parameters.end());
    batch.parameterOffset.push_back(batch.parameters.size());
    batch.following.push_back(core::kNoSymbol);
    batch.followingOffset.push_back(0);
  }
  return batch;
}

// a process with parameters of the kind it is used with: sizes of about half the distance between neighbours
struct Candidate {
  const char* name;
  std::string configuration;
  Parameters parameters;
  bool remembersSteps = false;  // unchanged parts are not computed again
};

std::vector<double> few(std::size_t i) {
  return {static_cast<double>(i % 7 + 1)};
}
std::vector<double> leaves(std::size_t i) {
  return i % 2 == 0 ? std::vector<double>{1.0, 0.1} : std::vector<double>{0.0};
}

std::vector<double> directions(std::size_t) {
  return {0.0, 0.0, 0.0, 0.0};
}

// a thousand solid spheres in the box that a million queries fill
std::string sphereLattice(const std::string& keys) {
  std::string rows;
  for (int i = 0; i < 1000; ++i) {
    rows += (rows.empty() ? "[" : ",[") + std::to_string(i % 10 * 10 + 5) + "," + std::to_string(i / 10 % 10 * 10 + 5) +
            "," + std::to_string(i / 100 * 10 + 5) + ",3]";
  }
  return R"({"spheres":[)" + rows + "]," + keys + "}";
}

const std::vector<Candidate>& candidates() {
  static const std::vector<Candidate> kCandidates{
      {"arvo", sphereLattice(R"("maxSurfaceDistance":3)"),
       [](std::size_t) { return std::vector<double>{0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}; }},
      {"attractors", R"({"points":[[10,20,30,4],[90,80,70,-2],[50,50,50,1],[0,100,0,3]]})", directions},
      {"chiba", R"({"sources":[[0,1,0,4],[0.6,0.8,0,3],[-0.6,0.8,0,3]]})",
       [](std::size_t i) { return std::vector<double>{0.1 + 0.05 * static_cast<double>(i % 7)}; }, true},
      {"clover", R"({"range":[100,100],"position":[0,0],"gridSize":[2000,2000]})", leaves},
      {"colonization", R"({"markerCount":1000000,"markerBox":[0,0,0,100,100,100],"occupancyRadius":0.5})",
       [](std::size_t i) { return std::vector<double>(5, i % 2 == 0 ? 1.0 : 0.0); }},
      {"crowding", R"({"samples":32})",
       [](std::size_t i) {
         return std::vector<double>{i % 8 == 0 ? 0.0 : 0.05 * static_cast<double>(i % 7 + 1), 1.0, 0.0, 0.0, 0.0};
       }},
      {"density", "", [](std::size_t) { return std::vector<double>(3, 0.0); }},
      {"density3d", R"({"range":[100,100,100],"gridSize":[100,100,100]})", few},
      {"ecosystem", R"({"threeDimensional":true})",
       [](std::size_t i) {
         return std::vector<double>{0.1 * static_cast<double>(i % 7 + 1), 0.0};
       }},
      {"emission", R"({"gridSize":[50,50,50],"cellSize":2,"diffusivity":1})",
       [](std::size_t) {
         return std::vector<double>{0.1, 0.0, 0.0, 0.0};
       }},
      {"gravity", "", directions},
      {"height", "", few},
      {"honda", R"({"radius":0.5,"threeDimensional":true})", few},
      {"insects", R"({"count":1000,"reach":2})",
       [](std::size_t) {
         return std::vector<double>{1.0, 0.0};
       }},
      {"light-voxels", R"({"gridSize":[50,50,50],"voxelSize":2,"position":[0,0,0]})", few},
      {"meadow", R"({"gridSize":[500,500],"range":[100,100],"position":[0,0],"lightMap":[[0,255],[100,30]]})",
       [](std::size_t i) { return std::vector<double>(i % 4 == 0 ? 1 : 6, 0.5); }},
      {"multiple", R"({"fields":[{"type":"honda","radius":0.5,"threeDimensional":true},{"type":"height"}]})",
       [](std::size_t i) {
         return std::vector<double>{static_cast<double>(i % 2 + 1), static_cast<double>(i % 7)};
       }},
      {"obstacles", sphereLattice(R"("plants":"remembered","reach":10)"),
       [](std::size_t) { return std::vector<double>{0.3, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}; }},
      {"ornament", R"({"range":[100,100],"position":[0,0],"gridSize":[2000,2000]})",
       [](std::size_t) {
         return std::vector<double>{0.0, 0.2};
       }},
      {"shadow", "", few},
      {"soil", R"({"domainSize":[100,100,100],"gridSize":[100,100,1],"depletion":true})",
       [](std::size_t) {
         return std::vector<double>{0.001, 1.0, 1.0, 0.0};
       }},
      {"soil-water",
       R"({"gridSize":[20,20,20],"cellSize":[5,5,5],"position":[0,0,0],"layers":[[100,0.05,0.4,2,1.6,0.2]]})",
       [](std::size_t) {
         return std::vector<double>{1e-4, 0.0, 0.0};
       }},
      {"takenaka", R"({"sources":[[0,1000,0,4],[500,800,0,3]]})",
       [](std::size_t) {
         return std::vector<double>{0.2, 0.0};
       },
       true},
      {"wind", R"({"profile":"logarithmic"})", directions},
  };
  return kCandidates;
}

void process(benchmark::State& state, const Candidate& candidate) {
  const Process environment = makeProcess(candidate.name, candidate.configuration);
  turtle::EnvironmentContext context;
  context.symbols = {"E"};
  const turtle::QueryBatch queries = makeQueries(static_cast<std::size_t>(state.range(0)), candidate.parameters);
  turtle::ReplyBatch replies;
  for (auto _ : state) {
    state.PauseTiming();
    replies.prepare(queries);
    if (const auto error = environment->open(context)) {
      state.SkipWithError(error->message.c_str());
      return;
    }
    state.ResumeTiming();
    if (const auto error = environment->step(queries, replies)) {
      state.SkipWithError(error->message.c_str());
      return;
    }
  }
  state.counters["queries"] = Counter(static_cast<double>(queries.size()));
  state.counters["queries/s"] = Counter(static_cast<double>(queries.size()), Counter::kIsIterationInvariantRate);
}

// a step in which one of a hundred organs is elsewhere, by a process that saw the step before, and beside it by a new
// one
void changeOfStep(benchmark::State& state, const Candidate& candidate) {
  const auto count = static_cast<std::size_t>(state.range(0));
  std::array<turtle::QueryBatch, 2> steps{makeQueries(count, candidate.parameters),
                                          makeQueries(count, candidate.parameters)};
  const double side = std::cbrt(static_cast<double>(count));
  for (std::size_t i = 0; i < count; i += 100) {
    core::Vec3& position = steps[1].position[i];
    position.x += position.x < side / 2.0 ? side / 2.0 : -side / 2.0;
  }
  turtle::ReplyBatch replies;
  const auto secondsOf = [&](turtle::EnvironmentProcess& environment, const turtle::QueryBatch& queries) {
    replies.prepare(queries);
    const auto start = Clock::now();
    const auto error = environment.step(queries, replies);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (error) {
      throw std::runtime_error(error->message);
    }
    return seconds;
  };
  turtle::EnvironmentContext context;
  context.symbols = {"E"};
  double kept = 1e30;
  double anew = 1e30;
  const Process environment = makeProcess(candidate.name, candidate.configuration);
  for (auto _ : state) {
    static_cast<void>(environment->open(context));
    anew = std::min(anew, secondsOf(*environment, steps[0]));
    const double seconds = secondsOf(*environment, steps[1]);
    state.SetIterationTime(seconds);
    kept = std::min(kept, seconds);
  }
  state.counters["anew ms"] = Counter(anew * 1e3);
  state.counters["gain"] = Counter(anew / kept);
  state.counters["queries/s"] = Counter(static_cast<double>(count) / kept);
}

// a thousand segments more among those that have grown, and beside it the same with all of these brought anew
void growthAmongSegments(benchmark::State& state) {
  const auto makeObstacles = [] { return makeProcess("obstacles", R"({"plants":"remembered"})"); };
  const auto parameters = [](std::size_t) { return std::vector<double>{0.3, 0.05}; };
  const turtle::QueryBatch grown = makeQueries(static_cast<std::size_t>(state.range(0)), parameters);
  turtle::QueryBatch more = makeQueries(1000, parameters);
  const double scale = std::cbrt(static_cast<double>(state.range(0)) / 1000.0);
  for (core::Vec3& position : more.position) {
    position = position * scale;
  }
  turtle::ReplyBatch replies;
  const auto stepOf = [&](turtle::EnvironmentProcess& obstacles, const turtle::QueryBatch& queries) {
    replies.prepare(queries);
    static_cast<void>(obstacles.step(queries, replies));
  };
  const Process first = makeObstacles();
  static_cast<void>(first->open({}));
  stepOf(*first, grown);
  const std::string saved = first->save();
  double kept = 1e30;
  double anew = 1e30;
  for (auto _ : state) {
    const Process obstacles = makeObstacles();
    static_cast<void>(obstacles->open({}));
    const auto begin = Clock::now();
    static_cast<void>(obstacles->restore(saved));
    const auto start = Clock::now();
    stepOf(*obstacles, more);
    const auto end = Clock::now();
    state.SetIterationTime(std::chrono::duration<double>(end - start).count());
    kept = std::min(kept, std::chrono::duration<double>(end - start).count());
    anew = std::min(anew, std::chrono::duration<double>(end - begin).count());
  }
  state.counters["anew ms"] = Counter(anew * 1e3);
  state.counters["gain"] = Counter(anew / kept);
  state.counters["queries/s"] = Counter(1000.0 / kept);
}

// a field that is swept whole: what a tick reads and writes
struct Sweep {
  const char* name;
  const char* process;
  int dimensions;  // of range(0) cells each
  const char* keys;
  double sweeps;  // of the whole field in a tick
};

const std::vector<Sweep>& sweeps() {
  static const std::vector<Sweep> kSweeps{
      {"soil", "soil", 2, R"("diffusionSteps":10)", 10.0},
      {"soil-space", "soil", 3, R"("diffusionSteps":10)", 10.0},
      // 6 · D · 1 day/1² = 3.6: four steps of at most 0.9; the decay is in the last of them
      {"emission", "emission", 3, R"("diffusivity":0.6,"decayRate":0.1)", 4.0},
  };
  return kSweeps;
}

void sweepField(benchmark::State& state, const Sweep& sweep) {
  const std::string side = std::to_string(state.range(0));
  const Process process =
      makeProcess(sweep.process, R"({"gridSize":[)" + side + "," + side + "," + (sweep.dimensions == 3 ? side : "1") +
                                     "]," + sweep.keys + "}");
  if (const auto error = process->open({})) {
    state.SkipWithError(error->message.c_str());
    return;
  }
  double best = 1e30;
  for (auto _ : state) {
    const auto start = Clock::now();
    if (const auto error = process->tick(0)) {
      state.SkipWithError(error->message.c_str());
      return;
    }
    best = std::min(best, std::chrono::duration<double>(Clock::now() - start).count());
  }
  // each sweep reads one buffer and writes the other
  const double bytes = std::pow(static_cast<double>(state.range(0)), sweep.dimensions) * sizeof(double);
  state.counters["bytes/s"] = Counter(2.0 * bytes * sweep.sweeps / best);
  state.counters["copied bytes/s"] = Counter(copiedBytesPerSecond(static_cast<std::size_t>(bytes)));
}

// a field that queries write and read: voxels that a query touches, 8 bytes each. The plain copy beside it has as many
// bytes as the whole field
struct Touch {
  const char* process;
  const char* configuration;
  double voxelsPerQuery;
  double voxelCount;
  Parameters parameters;
};

const std::vector<Touch>& touches() {
  static const std::vector<Touch> kTouches{
      // written once, read once
      {"density3d", R"({"range":[100,100,100],"gridSize":[100,100,100]})", 2.0, 1e6, few},
      // a pyramid of 1 + 9 + 25 + 49 + 81 + 121 voxels is read and written, and 8 are read for the light
      {"shadow", "", 2.0 * 286.0 + 8.0, 201.0 * 101.0 * 201.0, few},
  };
  return kTouches;
}

void touchField(benchmark::State& state, const Touch& touch) {
  const Process process = makeProcess(touch.process, touch.configuration);
  const turtle::QueryBatch queries = makeQueries(static_cast<std::size_t>(state.range(0)), touch.parameters);
  turtle::ReplyBatch replies;
  double best = 1e30;
  for (auto _ : state) {
    // opened again it has nothing left of the step before
    if (const auto error = process->open({})) {
      state.SkipWithError(error->message.c_str());
      return;
    }
    replies.prepare(queries);
    const auto start = Clock::now();
    if (const auto error = process->step(queries, replies)) {
      state.SkipWithError(error->message.c_str());
      return;
    }
    best = std::min(best, std::chrono::duration<double>(Clock::now() - start).count());
  }
  const double touched = static_cast<double>(queries.size()) * touch.voxelsPerQuery * sizeof(double);
  state.counters["bytes/s"] = Counter(touched / best);
  state.counters["copied bytes/s"] =
      Counter(copiedBytesPerSecond(static_cast<std::size_t>(touch.voxelCount * sizeof(double))));
}

const bool kIsRegistered = [] {
  // the first two are the reference's open.l and its like, grown; the third has been at rest for a while
  for (const auto& [model, firstStep] :
       std::vector<std::pair<std::string, std::uint64_t>>{{"open", 18}, {"open-branching", 18}, {"open-steady", 40}}) {
    for (const unsigned threads : {1U, 2U}) {
      benchmark::RegisterBenchmark((model + "/height/" + std::to_string(threads)).c_str(),
                                   [model = model, firstStep = firstStep, threads](benchmark::State& state) {
                                     answerSteps(state, model, firstStep, "height", threads);
                                   })
          ->Unit(benchmark::kMillisecond)
          ->UseManualTime();
    }
  }
  for (const auto& [name, configuration] : std::vector<std::pair<std::string, std::string>>{
           {"constant", ""}, {"height", ""}, {"honda", R"({"radius":0.5,"threeDimensional":true})"}}) {
    benchmark::RegisterBenchmark(
        ("answer/" + name).c_str(),
        [name = name, configuration = configuration](benchmark::State& state) { answer(state, name, configuration); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
  for (const Candidate& candidate : candidates()) {
    benchmark::RegisterBenchmark((std::string("process/") + candidate.name).c_str(),
                                 [&candidate](benchmark::State& state) { process(state, candidate); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime()
        ->RangeMultiplier(10)
        ->Range(100, 1'000'000);
    if (candidate.remembersSteps) {
      benchmark::RegisterBenchmark((std::string("change/") + candidate.name).c_str(),
                                   [&candidate](benchmark::State& state) { changeOfStep(state, candidate); })
          ->Unit(benchmark::kMillisecond)
          ->UseManualTime()
          ->Arg(10'000)
          ->Arg(100'000);
    }
  }
  benchmark::RegisterBenchmark("change/obstacles", growthAmongSegments)
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime()
      ->Arg(10'000)
      ->Arg(100'000);
  for (const Sweep& sweep : sweeps()) {
    benchmark::RegisterBenchmark((std::string("field/") + sweep.name).c_str(),
                                 [&sweep](benchmark::State& state) { sweepField(state, sweep); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime()
        ->Arg(sweep.dimensions == 2 ? 256 : 40)
        ->Arg(sweep.dimensions == 2 ? 2048 : 150);
  }
  for (const Touch& touch : touches()) {
    benchmark::RegisterBenchmark((std::string("field/") + touch.process).c_str(),
                                 [&touch](benchmark::State& state) { touchField(state, touch); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime()
        ->Arg(100'000);
  }
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

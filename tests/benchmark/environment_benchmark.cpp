// The other half of a step: interpretation for queries, answers, and writing them back; and the processes alone.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tests/benchmark/workload.h"

namespace espalier::benchmarking {
namespace {

using Counter = benchmark::Counter;
using Process = std::unique_ptr<turtle::EnvironmentProcess>;
using Clock = std::chrono::steady_clock;

// the environment part of the reference's open.l over the steps in which it is grown: `environmentMilliseconds` of
// `espalier derive --environment PROCESS --statistics`, steps 18 to 37
void answerSteps(benchmark::State& state, const std::string& model, const std::string& name, unsigned threads) {
  constexpr std::uint64_t kFirstStep = 18;
  const auto program = compileWorkload({model, "37", ""});
  simulation::SimulationOptions options;
  options.threads = threads;
  std::uint64_t queries = 0;
  double best = 1e30;
  for (auto _ : state) {
    simulation::Simulation simulation(program, {turtle::PlantPlacement{}}, makeProcess(name, ""), options);
    require(simulation.rewind());
    double seconds = 0.0;
    queries = 0;
    while (!simulation.isFinished()) {
      const auto start = Clock::now();
      require(simulation.answer());
      if (simulation.completedSteps() + 1 >= kFirstStep) {
        seconds += std::chrono::duration<double>(Clock::now() - start).count();
        queries += simulation.statistics().queries;
      }
      require(simulation.step());
    }
    state.SetIterationTime(seconds);
    best = std::min(best, seconds);
  }
  state.counters["best ms"] = Counter(best * 1e3);
  state.counters["queries"] = Counter(static_cast<double>(queries));
  state.counters["queries/s"] = Counter(static_cast<double>(queries) / best);
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
    batch.plant.push_back(0);
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
  const char* configuration;
  Parameters parameters;
};

std::vector<double> few(std::size_t i) {
  return {static_cast<double>(i % 7 + 1)};
}
std::vector<double> leaves(std::size_t i) {
  return i % 2 == 0 ? std::vector<double>{1.0, 0.1} : std::vector<double>{0.0};
}

const std::vector<Candidate>& candidates() {
  static const std::vector<Candidate> kCandidates{
      {"chiba", R"({"sources":[[0,1,0,4],[0.6,0.8,0,3],[-0.6,0.8,0,3]]})",
       [](std::size_t i) { return std::vector<double>{0.1 + 0.05 * static_cast<double>(i % 7)}; }},
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
      {"height", "", few},
      {"honda", R"({"radius":0.5,"threeDimensional":true})", few},
      {"light-voxels", R"({"gridSize":[50,50,50],"voxelSize":2,"position":[0,0,0]})", few},
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
       }},
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

// diffusion alone: how fast a field of range(0)^2 cells is read and written
void diffusion(benchmark::State& state) {
  const std::string side = std::to_string(state.range(0));
  constexpr int kSteps = 10;
  const Process soil = makeProcess("soil", R"({"gridSize":[)" + side + "," + side + R"(,1],"diffusionSteps":10})");
  if (const auto error = soil->open({})) {
    state.SkipWithError(error->message.c_str());
    return;
  }
  for (auto _ : state) {
    if (const auto error = soil->tick(0)) {
      state.SkipWithError(error->message.c_str());
      return;
    }
  }
  // each step reads one buffer and writes the other
  const double bytes = static_cast<double>(state.range(0) * state.range(0)) * kSteps * 2.0 * sizeof(double);
  state.counters["bytes/s"] = Counter(bytes, Counter::kIsIterationInvariantRate);
}

const bool kIsRegistered = [] {
  for (const std::string model : {"open", "open-branching"}) {
    for (const unsigned threads : {1U, 2U}) {
      benchmark::RegisterBenchmark(
          (model + "/height/" + std::to_string(threads)).c_str(),
          [model, threads](benchmark::State& state) { answerSteps(state, model, "height", threads); })
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
  }
  benchmark::RegisterBenchmark("diffusion/soil", diffusion)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->Arg(256)
      ->Arg(2048);
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

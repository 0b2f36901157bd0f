// Derivation alone, the work of README.md: all steps of a model from its axiom, allocation included.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "tests/benchmark/workload.h"

namespace espalier::benchmarking {
namespace {

using benchmark::Counter;

constexpr double kMinimumSeconds = 1.0;  // of timed runs
constexpr double kNever = 1e30;
constexpr int kCopiesPerRun = 3;  // a short time is known less well than a long one
// strings of fewer bytes come from memory that the process has already
constexpr std::uint64_t kSmallestResident = std::uint64_t{8} << 20U;

void setCounter(benchmark::State& state, const char* name, double value) {
  state.counters[name] = Counter(value);
}

// the figures of README.md for a run: those of the fastest run, beside the fastest copy
void report(benchmark::State& state, const DerivationRun& run, double seconds, double copySeconds) {
  const auto modules = static_cast<double>(run.modules);
  const double written =
      static_cast<double>(std::accumulate(run.stringBytes.begin(), run.stringBytes.end(), std::uint64_t{0}));
  setCounter(state, "best ms", seconds * 1e3);
  setCounter(state, "modules", modules);
  setCounter(state, "modules/s", modules / seconds);
  setCounter(state, "scanned/s", static_cast<double>(run.scannedModules) / seconds);
  setCounter(state, "bytes/module", static_cast<double>(run.stringBytes.back()) / modules);
  setCounter(state, "written bytes/s", written / seconds);
  setCounter(state, "copied bytes/s", written / copySeconds);
  if (run.stringBytes.back() >= kSmallestResident) {
    const std::uint64_t allowed =
        2 * (run.modules + run.previousModules) + 8 * (run.parameters + run.previousParameters);
    setCounter(state, "resident/string", static_cast<double>(run.residentBytes) / static_cast<double>(allowed));
  }
}

void derive(benchmark::State& state, const Workload& workload) {
  const auto program = compileWorkload(workload);
  DerivationRun run;
  double best = kNever;
  double bestCopy = kNever;
  for (auto _ : state) {
    run = runDerivation(program, 1);
    state.SetIterationTime(run.seconds);
    best = std::min(best, run.seconds);
    bestCopy = std::min(bestCopy, secondsToCopy(run.stringBytes, 1));
  }
  report(state, run, best, bestCopy);
}

// the same work by one thread and by two, in turn, and copied by one and by two
void compareThreads(benchmark::State& state, const Workload& workload) {
  const auto program = compileWorkload(workload);
  DerivationRun run = runDerivation(program, 2);
  double one = kNever;
  double two = kNever;
  double copyOne = kNever;
  double copyTwo = kNever;
  std::vector<double> shares;
  for (auto _ : state) {
    const double oneNow = runDerivation(program, 1).seconds;
    run = runDerivation(program, 2);
    double copyOneNow = kNever;
    double copyTwoNow = kNever;
    for (int copy = 0; copy < kCopiesPerRun; ++copy) {
      copyOneNow = std::min(copyOneNow, secondsToCopy(run.stringBytes, 1));
      copyTwoNow = std::min(copyTwoNow, secondsToCopy(run.stringBytes, 2));
    }
    one = std::min(one, oneNow);
    two = std::min(two, run.seconds);
    copyOne = std::min(copyOne, copyOneNow);
    copyTwo = std::min(copyTwo, copyTwoNow);
    shares.push_back(oneNow / run.seconds / (copyOneNow / copyTwoNow));
    state.SetIterationTime(run.seconds);
  }
  report(state, run, two, copyTwo);
  setCounter(state, "gain", one / two);
  setCounter(state, "copy gain", copyOne / copyTwo);
  std::nth_element(shares.begin(), shares.begin() + static_cast<std::ptrdiff_t>(shares.size() / 2), shares.end());
  setCounter(state, "median share", shares[shares.size() / 2]);
}

void add(const std::string& name, void (*body)(benchmark::State&, const Workload&), const Workload& workload) {
  benchmark::RegisterBenchmark((name + workload.name()).c_str(),
                               [body, workload](benchmark::State& state) { body(state, workload); })
      ->Unit(benchmark::kMillisecond)
      ->MinTime(kMinimumSeconds)
      ->UseManualTime();
}

const bool kIsRegistered = [] {
  // the reference's workloads
  for (const Workload& workload :
       {Workload{"d0l", "11", ""}, Workload{"parametric", "20", ""}, Workload{"parametric", "22", ""},
        Workload{"signal-up", "123", ""}, Workload{"diffusion", "123", ""}, Workload{"signal-down", "123", ""},
        Workload{"stochastic", "13", ""}}) {
    add("derive/", derive, workload);
  }
  // those that make or read more than 10 million modules, and what only one module at a time does
  for (const Workload& workload :
       {Workload{"d0l", "11", ""}, Workload{"parametric", "20", ""}, Workload{"parametric", "22", ""},
        Workload{"stochastic", "13", ""}, Workload{"signal-up", "123", ""}, Workload{"diffusion", "123", ""},
        Workload{"signal-down", "123", ""}, Workload{"decomposition", "24", "16"}, Workload{"draws", "28", "18"},
        Workload{"pairs", "26", "17"}}) {
    add("derive-threads/", compareThreads, workload);
  }
  // no cliff: 128 and 8,192 modules, many productions, many parameters, deep nesting, many branches at a node, many
  // ignored modules in a row, wide contexts, chance with contexts, decomposition, cheap productions everywhere, a rare
  // module of the general way
  for (const Workload& workload : {Workload{"steady", "4000", "7"},       Workload{"steady", "400", "13"},
                                   Workload{"steady", "60", "20"},        Workload{"d0l", "6", ""},
                                   Workload{"parametric", "8", ""},       Workload{"productions", "60", "7"},
                                   Workload{"productions", "60", "14"},   Workload{"parameters", "400", "7"},
                                   Workload{"parameters", "40", "14"},    Workload{"nesting", "1000", ""},
                                   Workload{"fan", "30", "10"},           Workload{"ignored-rows", "30", "10"},
                                   Workload{"ignored-rows", "30", "14"},  Workload{"wide-contexts", "200", "7"},
                                   Workload{"wide-contexts", "40", "14"}, Workload{"stochastic-contexts", "60", "12"},
                                   Workload{"decomposition", "60", "6"},  Workload{"decomposition", "30", "12"},
                                   Workload{"signal-up", "8", ""},        Workload{"signal-up", "60", ""},
                                   Workload{"dense-cheap", "4000", "7"},  Workload{"dense-cheap", "400", "13"},
                                   Workload{"rare-general", "400", "1"},  Workload{"rare-general", "60", "7"}}) {
    add("derive-cliff/", derive, workload);
  }
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

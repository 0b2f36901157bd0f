// The text of long strings, into memory: `text/MODEL/N/THREADS`, in turn beside a plain copy of as many bytes.

#include <benchmark/benchmark.h>

#include <chrono>
#include <cstring>

#include "engine/core/buffer.h"
#include "engine/derivation/parallel/text_writer.h"
#include "engine/derivation/state/string_text.h"
#include "tests/benchmark/workload.h"

namespace espalier::benchmarking {
namespace {

using Clock = std::chrono::steady_clock;

/// Keeps a text in memory that is touched once and then used again.
class MemorySink final : public core::ByteSink {
 public:
  void write(std::string_view bytes) override { text_.append(bytes); }
  void clear() { text_.clear(); }
  [[nodiscard]] const core::Buffer<char>& text() const { return text_; }

 private:
  core::Buffer<char> text_;
};

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void writeText(benchmark::State& state, const Workload& workload, unsigned threads) {
  const auto program = compileWorkload(workload);
  simulation::Simulation simulation(program, {turtle::PlantPlacement{}}, nullptr, {});
  require(simulation.rewind());
  while (!simulation.isFinished()) {
    require(simulation.step());
  }
  derivation::TextWriter writer(threads);
  MemorySink sink;
  core::Buffer<char> copy;
  double textSeconds = 0.0;
  double copySeconds = 0.0;
  for (auto _ : state) {
    sink.clear();
    const auto start = Clock::now();
    writer.write(sink, *program, simulation.string(), derivation::numberStyle(program->compatibility));
    textSeconds += secondsSince(start);
    copy.resize(sink.text().size());
    const auto middle = Clock::now();
    std::memcpy(copy.data(), sink.text().data(), copy.size());
    copySeconds += secondsSince(middle);
  }
  const auto bytes = static_cast<double>(sink.text().size()) * static_cast<double>(state.iterations());
  state.counters["modules"] = benchmark::Counter(static_cast<double>(simulation.string().size()));
  state.counters["GB/s text"] = benchmark::Counter(bytes / textSeconds / 1e9);
  state.counters["GB/s copied"] = benchmark::Counter(bytes / copySeconds / 1e9);
}

const bool kIsRegistered = [] {
  for (const Workload& workload :
       {Workload{"d0l", "10", ""}, Workload{"stochastic", "12", ""}, Workload{"parametric", "19", ""},
        Workload{"parameters", "14", ""}, Workload{"diffusion", "123", ""}}) {
    for (const unsigned threads : {1U, 2U}) {
      benchmark::RegisterBenchmark(
          ("text/" + workload.name() + "/" + std::to_string(threads)).c_str(),
          [workload, threads](benchmark::State& state) { writeText(state, workload, threads); })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    }
  }
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

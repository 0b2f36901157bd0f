// Steps of a simulation that viewers watch, beside the same steps without viewers: the time of the thread that makes
// the steps. Viewers share the machine with the steps, and must not share their thread.
#include <benchmark/benchmark.h>

#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "server/running/interruption.h"
#include "server/server_core.h"
#include "server/session/session.h"

namespace espalier::benchmarking {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kViewers = 50;

/// Steps without viewers and with them take turns: other programs and the system's clock disturb single rounds.
constexpr int kRounds = 15;
constexpr int kRoundsOfLarge = 7;

/// A peer that reads everything at once, or nothing.
class ViewerConnection final : public server::Connection {
 public:
  explicit ViewerConnection(bool isReading) : isReading_(isReading) {}
  void send(std::shared_ptr<const std::string> line) override { queued_ += isReading_ ? 0 : line->size(); }
  void closeWhenSent() override {}
  void remind(std::chrono::milliseconds) override {}
  [[nodiscard]] std::size_t outboxBytes() const override { return queued_; }
  [[nodiscard]] std::string peerName() const override { return "viewer"; }

 private:
  const bool isReading_;
  std::atomic<std::size_t> queued_{0};
};

/// A tree whose leaves grow, one module in ten. With queries, one module in a hundred asks the environment.
std::string treeOf(const std::string& axiom, bool hasQueries) {
  return "Lsystem: 1\nderivation length: 100000\nAxiom: " + axiom + "\nS(n) : n == 4 --> [G(1)" +
         (hasQueries ? "?E(0)" : "") +
         "]F(1)[+(25)S(n-1)]/(137)F(0.9)[-(31)S(n-1)]\n"
         "S(n) : n > 0 --> F(1)[+(25)S(n-1)]/(137)F(0.9)[-(31)S(n-1)]\nS(n) --> G(1)\n"
         "G(x) --> G(x+0.001)\nendlsystem\n";
}

struct Kind {
  const char* name;
  const char* what;
  bool isInBlocks;
  bool isDelta;
  bool isSelective;  // each viewer has a selection of its own
  bool isReading;
};

constexpr Kind kKinds[] = {
    {"json", "turtle", false, false, false, true},      {"blocks", "turtle", true, false, false, true},
    {"differences", "turtle", true, true, false, true}, {"glb", "geometry", true, false, false, true},
    {"selections", "turtle", true, false, true, true},  {"never-reads", "turtle", true, false, false, false}};

/// Counts the instructions of this thread. They tell work from waiting for memory that viewers' threads use too.
class InstructionCounter {
 public:
  InstructionCounter() {
    perf_event_attr wanted{};
    wanted.size = sizeof(wanted);
    wanted.type = PERF_TYPE_HARDWARE;
    wanted.config = PERF_COUNT_HW_INSTRUCTIONS;
    wanted.exclude_kernel = 1;
    wanted.exclude_hv = 1;
    descriptor_ = static_cast<int>(::syscall(SYS_perf_event_open, &wanted, 0, -1, -1, 0));
  }
  ~InstructionCounter() {
    if (descriptor_ >= 0) {
      ::close(descriptor_);
    }
  }
  InstructionCounter(const InstructionCounter&) = delete;
  InstructionCounter& operator=(const InstructionCounter&) = delete;

  /// Nothing: the system does not count.
  [[nodiscard]] std::optional<double> count() const {
    std::uint64_t value = 0;
    const bool isRead = descriptor_ >= 0 && ::read(descriptor_, &value, sizeof(value)) == sizeof(value);
    return isRead ? std::optional(static_cast<double>(value)) : std::nullopt;
  }

 private:
  int descriptor_ = -1;
};

/// The simulation of a server, with steps that a benchmark asks for.
class Watched {
 public:
  Watched(server::ServerCore& core, const std::string& axiom, bool hasQueries) : core_(core) {
    core::MemoryFileProvider files;
    files.add("tree.l", treeOf(axiom, hasQueries));
    language::CompileInput input;
    input.modelFile = "tree.l";
    const auto compiled = language::compile(input, files);
    server::SimulationRecord record;
    record.id = core.reserve("", "").value();
    record.create.plants.emplace_back();
    record.create.environmentJson = hasQueries ? R"([{"type":"constant","values":[1]}])" : "";
    server::Interruption interruption;
    auto hosted =
        server::HostedSimulation::create(record, {compiled.program}, {}, core.limits().simulation,
                                         core.environmentServices(core.accounts().of("")), core.store(), interruption);
    core.add(record.id, std::move(hosted.value()));
    runner_ = core.find(record.id);
    // until nothing but the organs changes
    (void)step(20);
  }
  ~Watched() { core_.remove(runner_->id()); }

  struct Times {
    double cpuSeconds = 0.0;
    std::optional<double> instructions;
    std::vector<double> wallMicroseconds;
    std::uint64_t modules = 0;
  };

  /// Makes steps as simulation.run does, one turn for all of them.
  Times step(int count) {
    Times times;
    command([&](server::SimulationRunner& runner) {
      timespec begin{};
      timespec end{};
      const InstructionCounter counter;
      clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
      for (int i = 0; i < count; ++i) {
        const auto start = Clock::now();
        double milliseconds = 0.0;
        (void)runner.hosted().step(milliseconds);
        runner.publishState(true);
        times.wallMicroseconds.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
      }
      clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
      times.instructions = counter.count();
      times.cpuSeconds =
          static_cast<double>(end.tv_sec - begin.tv_sec) + 1e-9 * static_cast<double>(end.tv_nsec - begin.tv_nsec);
      times.modules = runner.hosted().simulation().statistics().modules;
    });
    return times;
  }

  void watch(const Kind& kind) {
    for (int i = 0; i < kViewers; ++i) {
      auto connection = std::make_shared<ViewerConnection>(kind.isReading);
      auto session = std::make_shared<server::Session>("viewer-" + std::to_string(i), core_, connection);
      protocol::StreamOpenParams params;
      params.simulation = runner_->id();
      params.what = kind.what;
      params.format = "glb";
      params.isInBlocks = kind.isInBlocks;
      params.isDelta = kind.isDelta;
      if (kind.isSelective) {
        // names that no module has make the selections differ
        params.select.symbols = {"F", "selection-" + std::to_string(i)};
      }
      command([stream = session->openStream(params, *runner_).value()](server::SimulationRunner& runner) {
        runner.addStream(stream);
      });
      sessions_.push_back(std::move(session));
    }
  }

  void end() {
    runner_->endStreams("the benchmark is over");
    core_.waitForWorkers();
  }

 private:
  void command(const std::function<void(server::SimulationRunner&)>& work) {
    std::promise<void> done;
    const auto command = std::make_shared<server::Command>();
    command->lane = server::Lane::Step;
    command->advance = [&](server::SimulationRunner& runner, server::Command&) {
      work(runner);
      done.set_value();
      return false;
    };
    command->fail = [&](const protocol::Error&) { done.set_value(); };
    runner_->submit(command);
    done.get_future().wait();
  }

  server::ServerCore& core_;
  std::shared_ptr<server::SimulationRunner> runner_;
  std::vector<std::shared_ptr<server::Session>> sessions_;
};

double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The figures of all rounds. Each ratio compares two neighbours in time.
class Rounds {
 public:
  void add(const Watched::Times& without, const Watched::Times& with) {
    alone_.push_back(medianOf(without.wallMicroseconds));
    watched_.push_back(medianOf(with.wallMicroseconds));
    wall_.push_back(watched_.back() / alone_.back());
    cpu_.push_back(with.cpuSeconds / without.cpuSeconds);
    if (with.instructions && without.instructions) {
      instructions_.push_back(*with.instructions / *without.instructions);
    }
  }
  void addNoise(const Watched::Times& first, const Watched::Times& second) {
    noise_.push_back(std::max(second.cpuSeconds / first.cpuSeconds, first.cpuSeconds / second.cpuSeconds));
  }

  void report(benchmark::State& state) const {
    state.SetIterationTime(medianOf(watched_) * 1e-6);
    state.counters["alone us"] = medianOf(alone_);
    state.counters["viewers cpu ratio"] = medianOf(cpu_);
    state.counters["viewers wall ratio"] = medianOf(wall_);
    state.counters["alone cpu ratio"] = medianOf(noise_);
    if (!instructions_.empty()) {
      state.counters["viewers instruction ratio"] = medianOf(instructions_);
    }
  }

 private:
  std::vector<double> alone_;         // median microseconds of a step, a round
  std::vector<double> watched_;       // the same with viewers
  std::vector<double> wall_;          // quotients
  std::vector<double> cpu_;           // the same of the thread's processor time
  std::vector<double> noise_;         // the same of two runs without viewers, the larger over the smaller
  std::vector<double> instructions_;  // the same; empty: the system does not count them
};

void stepWithViewers(benchmark::State& state, const Kind& kind, const std::string& axiom, bool hasQueries, int steps,
                     int roundCount) {
  server::ServerOptions options;
  options.logLevel = "off";
  server::ServerCore core(options);
  Watched alone(core, axiom, hasQueries);
  Watched watched(core, axiom, hasQueries);
  for (auto _ : state) {
    Rounds rounds;
    for (int round = 0; round < roundCount; ++round) {
      const Watched::Times without = alone.step(steps);
      watched.watch(kind);
      const Watched::Times with = watched.step(steps);
      watched.end();
      rounds.add(without, with);
      rounds.addNoise(without, watched.step(steps));
      state.counters["modules"] = static_cast<double>(with.modules);
    }
    rounds.report(state);
  }
}

const bool kIsRegistered = [] {
  for (const Kind& kind : kKinds) {
    for (const auto& [size, axiom, steps, rounds] : {std::tuple("7000", "S(9)S(7)S(6)", 10'000, kRounds),
                                                     std::tuple("1000000", "S(16)S(15)", 100, kRoundsOfLarge)}) {
      for (const bool hasQueries : {false, true}) {
        // a step that asks the environment takes twenty times as long
        const int count = hasQueries ? steps / 10 : steps;
        const std::string name = std::string("viewers/") + kind.name + "/" + size + (hasQueries ? "/queries" : "");
        benchmark::RegisterBenchmark(
            name.c_str(),
            [kind, axiom = axiom, hasQueries, count, rounds = rounds](benchmark::State& state) {
              stepWithViewers(state, kind, axiom, hasQueries, count, rounds);
            })
            ->Unit(benchmark::kMicrosecond)
            ->UseManualTime()
            ->Iterations(1);
      }
    }
  }
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

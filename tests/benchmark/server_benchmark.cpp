// A server in a process of its own: a step of a small plant there and back beside a bare echo of as many bytes, and the
// cost of a viewer of a big plant beside copying the changes.

#include <benchmark/benchmark.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio.hpp>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "protocol/json_writer.h"
#include "server/remote/processes/line_channel.h"
#include "server/stream/stream_frame.h"
#include "tests/support/places.h"

namespace espalier::benchmarking {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using Clock = std::chrono::steady_clock;

constexpr std::string_view kSmallPlant =
    "Lsystem: 1\nderivation length: 1000000\nAxiom: F(1)[+F(1)]?E(0)A(0)\nA(x) --> A(x+1)\nendlsystem\n";

/// Medians and 99th percentiles in microseconds.
struct Latency {
  double median = 0.0;
  double high = 0.0;
};

Latency latencyOf(std::vector<double>& microseconds) {
  std::sort(microseconds.begin(), microseconds.end());
  return {microseconds[microseconds.size() / 2], microseconds[microseconds.size() * 99 / 100]};
}

/// Which cores this thread may use, and what it starts, for as long as the object lives.
class OnCores {
 public:
  explicit OnCores(const cpu_set_t& cores) {
    (void)sched_getaffinity(0, sizeof before_, &before_);
    (void)sched_setaffinity(0, sizeof cores, &cores);
  }
  ~OnCores() { (void)sched_setaffinity(0, sizeof before_, &before_); }
  OnCores(const OnCores&) = delete;
  OnCores& operator=(const OnCores&) = delete;

 private:
  cpu_set_t before_{};
};

/// Where the asking side and the answering side run. Waking a thread of another core costs several microseconds more
/// than one of the same core, and where the system places two processes differs from run to run.
enum class Placement { OneCore, TwoCores, AsTheSystemLikes };

/// Of this thread's cores, the first or the last, or all.
cpu_set_t coresFor(Placement placement, bool isAsking) {
  cpu_set_t all{};
  (void)sched_getaffinity(0, sizeof all, &all);
  if (placement == Placement::AsTheSystemLikes) {
    return all;
  }
  int first = -1;
  int last = -1;
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (CPU_ISSET(core, &all)) {
      first = first < 0 ? core : first;
      last = core;
    }
  }
  cpu_set_t one{};
  CPU_SET(placement == Placement::OneCore || isAsking ? first : last, &one);
  return one;
}

/// `espalier serve` on a free port, nothing kept on a disk.
struct Serving {
  Serving() {
    const std::string program = buildFolder() + "/bin/espalier";
    auto result = server::ChildProcess::start("exec '" + program + "' serve --listen 127.0.0.1:0 --log-level off");
    if (!result) {
      throw std::runtime_error(result.error());
    }
    started = std::move(*result);
    channel.emplace(std::move(started->input), std::move(started->output), 1'000);
    std::string line;
    (void)channel->readLine(line, Clock::now() + std::chrono::seconds(30));
    address = line.substr(line.rfind(' ') + 1);
  }
  ~Serving() { started->process.end(); }
  Serving(const Serving&) = delete;
  Serving& operator=(const Serving&) = delete;

  std::unique_ptr<server::ChildProcess::Started> started;
  std::optional<server::LineChannel> channel;
  std::string address;
};

/// Reads up to the end of a line; how many bytes it had.
std::size_t readLine(tcp::socket& socket, asio::streambuf& buffer) {
  const std::size_t bytes = asio::read_until(socket, buffer, '\n');
  buffer.consume(bytes);
  return bytes;
}

/// How much time each answer took, and the length of answers.
struct RoundTrips {
  std::vector<double> microseconds;
  std::size_t answerBytes = 0;
};

RoundTrips measure(tcp::socket& socket, const std::string& line, std::size_t count) {
  RoundTrips trips;
  asio::streambuf buffer;
  for (std::size_t i = 0; i < count; ++i) {
    const auto begin = Clock::now();
    asio::write(socket, asio::buffer(line));
    trips.answerBytes = readLine(socket, buffer);
    trips.microseconds.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
  }
  return trips;
}

/// Answers every line with one of so many bytes, in a process of its own, as the server is.
class Echo {
 public:
  explicit Echo(std::size_t answerBytes) : acceptor_(context_, tcp::endpoint(asio::ip::make_address("127.0.0.1"), 0)) {
    child_ = fork();
    if (child_ == 0) {
      serve(answerBytes);
      _exit(0);
    }
  }
  ~Echo() {
    acceptor_.close();
    (void)waitpid(child_, nullptr, 0);
  }
  Echo(const Echo&) = delete;
  Echo& operator=(const Echo&) = delete;
  [[nodiscard]] tcp::endpoint endpoint() const { return acceptor_.local_endpoint(); }

 private:
  void serve(std::size_t answerBytes) {
    asio::io_context context;
    tcp::acceptor acceptor(context, tcp::v4(), acceptor_.release());
    const std::string answer = std::string(answerBytes - 1, 'x') + "\n";
    const auto answerAll = [&]() -> asio::awaitable<void> {
      tcp::socket socket = co_await acceptor.async_accept(asio::use_awaitable);
      socket.set_option(tcp::no_delay(true));
      std::string received;
      try {
        for (;;) {
          const std::size_t bytes =
              co_await asio::async_read_until(socket, asio::dynamic_buffer(received), '\n', asio::use_awaitable);
          received.erase(0, bytes);
          co_await asio::async_write(socket, asio::buffer(answer), asio::use_awaitable);
        }
      } catch (const boost::system::system_error&) {
        // the other side has closed
      }
    };
    asio::co_spawn(context, answerAll, asio::detached);
    context.run();
  }

  asio::io_context context_;
  tcp::acceptor acceptor_;
  pid_t child_ = 0;
};

std::string askOnce(tcp::socket& socket, const std::string& line) {
  asio::write(socket, asio::buffer(line));
  std::string answer;
  (void)asio::read_until(socket, asio::dynamic_buffer(answer), '\n');
  return answer;
}

tcp::socket connectTo(asio::io_context& context, const tcp::endpoint& endpoint) {
  tcp::socket socket(context);
  socket.connect(endpoint);
  socket.set_option(tcp::no_delay(true));
  return socket;
}

/// Round trips of a small plant on a new server, and of requests that its network's thread answers by itself.
struct ServerTrips {
  std::string stepLine;
  RoundTrips step;
  RoundTrips ping;
};

/// So many of each kind of round trip.
struct TripCounts {
  std::size_t warming = 0;
  std::size_t measured = 0;
};

RoundTrips measureWarm(tcp::socket& socket, const std::string& line, const TripCounts& counts) {
  (void)measure(socket, line, counts.warming);
  return measure(socket, line, counts.measured);
}

std::string stepOf(const std::string& simulation) {
  return R"({"jsonrpc":"2.0","id":3,"method":"simulation.step","params":{"simulation":")" + simulation + "\"}}\n";
}

/// Creates the small plant and returns its name.
std::string createSmallPlant(tcp::socket& socket) {
  (void)askOnce(socket, R"({"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1]}})"
                        "\n");
  protocol::JsonWriter source;
  source.text(kSmallPlant);
  const std::string created =
      askOnce(socket, R"({"jsonrpc":"2.0","id":2,"method":"simulation.create","params":{"seed":1,"save":false,)"
                      R"("environment":[{"type":"height"}],"model":{"source":)" +
                          source.view() + "}}}\n");
  const std::size_t at = created.find("sim-");
  if (at == std::string::npos) {
    throw std::runtime_error(created);
  }
  return created.substr(at, created.find('"', at) - at);
}

ServerTrips tripsOfServer(Placement placement, const TripCounts& counts) {
  std::optional<OnCores> cores(coresFor(placement, false));
  const Serving serving;
  cores.reset();
  cores.emplace(coresFor(placement, true));
  asio::io_context context;
  const auto port = static_cast<std::uint16_t>(std::stoi(serving.address.substr(serving.address.rfind(':') + 1)));
  tcp::socket socket = connectTo(context, {asio::ip::make_address("127.0.0.1"), port});
  ServerTrips trips;
  trips.stepLine = stepOf(createSmallPlant(socket));
  trips.step = measureWarm(socket, trips.stepLine, counts);
  trips.ping = measureWarm(socket,
                           R"({"jsonrpc":"2.0","id":3,"method":"ping","params":{}})"
                           "\n",
                           counts);
  return trips;
}

/// Of lines as long as those of the step there and back.
RoundTrips tripsOfEcho(Placement placement, const ServerTrips& like, const TripCounts& counts) {
  std::optional<OnCores> cores(coresFor(placement, false));
  const Echo echo(like.step.answerBytes);
  cores.reset();
  cores.emplace(coresFor(placement, true));
  asio::io_context context;
  tcp::socket socket = connectTo(context, echo.endpoint());
  return measureWarm(socket, like.stepLine, counts);
}

/// Server and echo in turn, so that both meet the same machine; each a new process and alone while it is measured. With
/// both alive, the one that rests while the other is measured is placed otherwise than it would be by itself.
void stepRoundTrip(benchmark::State& state, Placement placement) {
  constexpr int kRounds = 10;
  constexpr TripCounts kCounts{200, 1000};
  std::vector<double> step;
  std::vector<double> ping;
  std::vector<double> bare;
  const auto append = [](std::vector<double>& all, const RoundTrips& trips) {
    all.insert(all.end(), trips.microseconds.begin(), trips.microseconds.end());
  };
  for (auto _ : state) {
    step.clear();
    ping.clear();
    bare.clear();
    try {
      for (int round = 0; round < kRounds; ++round) {
        const ServerTrips trips = tripsOfServer(placement, kCounts);
        append(step, trips.step);
        append(ping, trips.ping);
        append(bare, tripsOfEcho(placement, trips, kCounts));
      }
    } catch (const std::exception& exception) {
      state.SkipWithError(exception.what());
      return;
    }
    const Latency server = latencyOf(step);
    const Latency asio = latencyOf(bare);
    state.SetIterationTime(server.median * 1e-6);
    state.counters["step median us"] = server.median;
    state.counters["step p99 us"] = server.high;
    state.counters["ping median us"] = latencyOf(ping).median;
    state.counters["echo median us"] = asio.median;
    state.counters["echo p99 us"] = asio.high;
  }
}

/// A plant of a million records that grows at one tip before them, on one axis.
constexpr std::string_view kTip =
    "Lsystem: 1\nderivation length: 100\nAxiom: [A]S(20)\nA --> F(2)A\n"
    "S(n) : n > 0 --> S(n-1)+(7)S(n-1)\nS(n) --> F(1)\nendlsystem\n";

/// A tree of a million modules with one branch, 1 % of them, whose lengths change in every step.
constexpr std::string_view kBranch =
    "Lsystem: 1\nderivation length: 100\nAxiom: S(17)[+(30)P(12)][-(30)S(17)]\n"
    "S(n) : n > 0 --> S(n-1)[+(7)S(n-1)]\nS(n) --> F(1)\n"
    "P(n) : n > 0 --> P(n-1)[+(7)P(n-1)]\nP(n) --> G(1)\nG(x) --> G(x+0.001)\nendlsystem\n";

/// A tree of 1.3 million modules in which nothing changes but organs `[G(x)]` at its branches of one level.
std::string treeWithOrgans(const std::string& organs) {
  return "Lsystem: 1\nderivation length: 100\nAxiom: S(17)\n" + organs +
         "S(n) : n > 0 --> F(1)[+(25)S(n-1)]/(137)F(0.9)[-(31)S(n-1)]\nS(n) --> F(1)\nG(x) --> "
         "G(x+0.001)\nendlsystem\n";
}
std::string organsAt(int level) {
  return "S(n) : n == " + std::to_string(level) + " --> [G(1)]F(1)[+(25)S(n-1)]/(137)F(0.9)[-(31)S(n-1)]\n";
}

std::unique_ptr<simulation::Simulation> grownPlant(std::string_view model) {
  language::CompileInput input;
  core::MemoryFileProvider files;
  files.add("big.l", std::string(model));
  input.modelFile = "big.l";
  auto compiled = language::compile(input, files);
  auto simulation = std::make_unique<simulation::Simulation>(compiled.program, std::vector<turtle::PlantPlacement>(1),
                                                             nullptr, simulation::SimulationOptions{});
  (void)simulation->rewind();
  for (int step = 0; step < 22; ++step) {
    (void)simulation->step();
  }
  return simulation;
}

/// Milliseconds of copying so many bytes, the median.
double copyMilliseconds(std::uint64_t bytes) {
  std::vector<double> copying;
  const std::string from(bytes, 'x');
  for (int i = 0; i < 20; ++i) {
    std::string to(bytes, 'y');
    const auto begin = Clock::now();
    std::memcpy(to.data(), from.data(), bytes);
    benchmark::DoNotOptimize(to.data());
    copying.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
  }
  return latencyOf(copying).median * 1e-3;
}

void viewBigPlant(benchmark::State& state, std::string_view model, bool isDelta) {
  const auto simulation = grownPlant(model);
  protocol::StreamOpenParams params;
  params.what = "turtle";
  params.isDelta = isDelta;
  params.isInBlocks = true;
  server::FrameBase base;
  simulation::ViewDrawing drawing;
  simulation->followChanges(isDelta);
  const auto makeFrame = [&] {
    drawing.show(simulation->takeView());
    server::FrameMaker maker(drawing, 0.0, nullptr);
    return maker.make(params, base).value();
  };
  const auto beginning = Clock::now();
  base = makeFrame().base;
  state.counters["first ms"] = std::chrono::duration<double, std::milli>(Clock::now() - beginning).count();
  std::vector<double> making;
  std::vector<double> sending;
  std::uint64_t bytes = 0;
  for (auto _ : state) {
    (void)simulation->step();
    auto begin = Clock::now();
    server::StreamFrame frame = makeFrame();
    making.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
    begin = Clock::now();
    std::string sent;
    sent.reserve(frame.body.blocks.totalBytes());
    frame.body.blocks.appendTo(sent);
    benchmark::DoNotOptimize(sent.data());
    sending.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
    state.SetIterationTime((making.back() + sending.back()) * 1e-6);
    bytes = sent.size();
    base = std::move(frame.base);
  }
  state.counters["frame bytes"] = static_cast<double>(bytes);
  const derivation::ModuleString& string = simulation->string();
  state.counters["modules"] = static_cast<double>(string.size());
  state.counters["making ms"] = latencyOf(making).median * 1e-3;
  state.counters["sending ms"] = latencyOf(sending).median * 1e-3;
  // copies of as many bytes, and of the string, which has to be read to find what has changed
  state.counters["copy ms"] = copyMilliseconds(bytes);
  state.counters["string copy ms"] = copyMilliseconds(string.bytes());
}

const bool kIsRegistered = [] {
  for (const auto& [name, placement] :
       {std::pair("one-core", Placement::OneCore), std::pair("two-cores", Placement::TwoCores),
        std::pair("free", Placement::AsTheSystemLikes)}) {
    benchmark::RegisterBenchmark(("server/step-round-trip/" + std::string(name)).c_str(),
                                 [placement](benchmark::State& state) { stepRoundTrip(state, placement); })
        ->Unit(benchmark::kMillisecond)
        ->UseManualTime()
        ->Iterations(3);
  }
  struct View {
    const char* name;
    std::string model;
    bool isDelta;
  };
  for (const View& view :
       {View{"stream/whole/1000000", std::string(kTip), false}, View{"stream/delta/1000000", std::string(kTip), true},
        View{"stream/whole-tree/1000000", std::string(kBranch), false},
        View{"stream/delta-branch/1000000", std::string(kBranch), true},
        View{"stream/delta-nothing", treeWithOrgans(""), true},
        View{"stream/delta-each/10000", treeWithOrgans(organsAt(10)), true},
        View{"stream/delta-each/160", treeWithOrgans(organsAt(4)), true},
        View{"stream/delta-all", treeWithOrgans("S(n) : n == 0 --> G(1)\n"), true}}) {
    benchmark::RegisterBenchmark(view.name,
                                 [view](benchmark::State& state) { viewBigPlant(state, view.model, view.isDelta); })
        ->Unit(benchmark::kMillisecond)
        ->UseManualTime()
        ->Iterations(10);
  }
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

// Environments in another process: queries out and replies back, a core for each side. And the wire alone: what writing
// and reading the messages costs.

#include <benchmark/benchmark.h>

#include <array>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "environment/registry.h"
#include "protocol/codec.h"
#include "protocol/framing.h"
#include "server/remote/processes/line_channel.h"
#include "server/remote/remote_environment.h"
#include "server/remote/translation/translate_environment.h"
#include "tests/support/places.h"

namespace espalier::benchmarking {
namespace {

using Counter = benchmark::Counter;
using Process = std::unique_ptr<turtle::EnvironmentProcess>;

constexpr std::size_t kQueryCount = 65'536;

/// Queries with a position of all its digits and one parameter, as open.l asks.
turtle::QueryBatch makeQueries(std::size_t count) {
  turtle::QueryBatch batch;
  batch.parameterOffset.push_back(0);
  batch.followingOffset.push_back(0);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = static_cast<double>(i) * 0.7;
    batch.plant.push_back(0);
    batch.module.push_back(2 * i);
    batch.symbol.push_back(0);
    batch.isTransient.push_back(0);
    batch.position.push_back({std::sin(angle), std::sqrt(static_cast<double>(i)), std::cos(angle)});
    batch.parameters.push_back(0.0);
    batch.parameterOffset.push_back(i + 1);
    batch.followingOffset.push_back(0);
  }
  return batch;
}

turtle::EnvironmentContext context() {
  turtle::EnvironmentContext made;
  made.simulation = "benchmark";
  made.symbols = {"E"};
  return made;
}

void count(benchmark::State& state, std::size_t queries) {
  state.counters["queries"] = Counter(static_cast<double>(queries));
  state.counters["queries/s"] = Counter(static_cast<double>(queries), Counter::kIsIterationInvariantRate);
}

void ask(benchmark::State& state, turtle::EnvironmentProcess& process, std::size_t queryCount) {
  turtle::QueryBatch queries = makeQueries(queryCount);
  turtle::ReplyBatch replies;
  if (const auto error = process.open(context())) {
    state.SkipWithError(error->message.c_str());
    return;
  }
  for (auto _ : state) {
    replies.prepare(queries);
    if (const auto error = process.step(queries, replies)) {
      state.SkipWithError(error->message.c_str());
      return;
    }
    ++queries.step;
  }
  count(state, queryCount);
}

/// `espalier environment height` on a free port.
struct Served {
  Served() {
    const std::string program = buildFolder() + "/bin/espalier";
    auto result = server::ChildProcess::start("exec '" + program + "' environment height --listen 127.0.0.1:0");
    if (!result) {
      throw std::runtime_error(result.error());
    }
    started = std::move(*result);
    channel.emplace(std::move(started->input), std::move(started->output), 1'000);
    std::string line;
    (void)channel->readLine(line, std::chrono::steady_clock::now() + std::chrono::seconds(30));
    address = "tcp://" + line.substr(line.rfind(' ') + 1);
  }
  ~Served() { started->process.end(); }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  std::unique_ptr<server::ChildProcess::Started> started;
  std::optional<server::LineChannel> channel;
  std::string address;
};

void askOverTcp(benchmark::State& state, bool isTextOnly, std::size_t queryCount) {
  const Served served;
  server::RemoteEnvironmentOptions options;
  options.isTextOnly = isTextOnly;
  auto connected = server::connectRemoteEnvironment(served.address, options);
  if (!connected) {
    state.SkipWithError(connected.error().c_str());
    return;
  }
  ask(state, *connected.value(), queryCount);
}

void askInside(benchmark::State& state, std::size_t queryCount) {
  auto made = environment::makeProcess("height", "");
  ask(state, *made.value(), queryCount);
}

/// The messages of a step without a socket between: written, read, translated, and the same for the replies.
void codec(benchmark::State& state, bool isBinary) {
  const turtle::QueryBatch queries = makeQueries(kQueryCount);
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  for (std::size_t i = 0; i < kQueryCount; ++i) {
    replies.set(queries, i, 0, queries.position[i].y);
  }
  protocol::NeedsRecord needs;
  needs.position = true;
  turtle::EnvironmentNeeds engineNeeds;
  engineNeeds.position = true;
  protocol::MessageReader reader{protocol::FrameLimits{}};
  reader.allowBlocks();
  for (auto _ : state) {
    const auto params = server::toStepParams("s", queries, needs, {"E"});
    reader.feed(
        protocol::encodeRequest(protocol::MessageId::of(1), "environment.step",
                                isBinary ? protocol::encodeBlocks(params) : protocol::Body(protocol::encode(params))));
    const auto asked = reader.next();
    const auto decoded = protocol::decodeEnvironmentStepParams(asked->value().payload);
    std::vector<std::string> symbols{"E"};
    const turtle::QueryBatch batch = server::toBatch(decoded.value(), engineNeeds, symbols);
    const auto columns = server::toReplies(batch, replies);
    reader.feed(protocol::encodeResult(protocol::MessageId::of(1), isBinary
                                                                       ? protocol::encodeBlocks(columns)
                                                                       : protocol::Body(protocol::encode(columns))));
    const auto answered = reader.next();
    const auto read = protocol::decodeReplies(answered->value().payload, kQueryCount);
    turtle::ReplyBatch applied;
    applied.prepare(queries);
    server::applyReplies(read.value(), queries, applied);
    benchmark::DoNotOptimize(applied.values.data());
  }
  count(state, kQueryCount);
}

void registerRemote(const std::string& name, std::function<void(benchmark::State&)> body) {
  benchmark::RegisterBenchmark(name.c_str(), std::move(body))->Unit(benchmark::kMillisecond)->UseRealTime();
}

const bool kIsRegistered = [] {
  registerRemote("remote/inside", [](benchmark::State& state) { askInside(state, kQueryCount); });
  registerRemote("remote/tcp-binary", [](benchmark::State& state) { askOverTcp(state, false, kQueryCount); });
  registerRemote("remote/tcp-text", [](benchmark::State& state) { askOverTcp(state, true, kQueryCount); });
  registerRemote("remote/tcp-binary-small", [](benchmark::State& state) { askOverTcp(state, false, 16); });
  registerRemote("remote/tcp-text-small", [](benchmark::State& state) { askOverTcp(state, true, 16); });
  registerRemote("codec/binary", [](benchmark::State& state) { codec(state, true); });
  registerRemote("codec/text", [](benchmark::State& state) { codec(state, false); });
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking

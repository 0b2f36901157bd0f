#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "clients/cpp/client.h"
#include "clients/espalier/client_token.h"
#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/number_option.h"
#include "clients/espalier/server_connection.h"
#include "protocol/envelope.h"
#include "protocol/json_text.h"
#include "protocol/json_writer.h"

namespace espalier::command {
namespace {

using Clock = std::chrono::steady_clock;
using ConnectionPointer = std::unique_ptr<ServerConnection>;

struct LoadOptions {
  ServerAddress server;
  std::string token;
  unsigned sessions = 4;
  unsigned viewers = 0;
  unsigned idle = 0;
  unsigned queries = 16;
  double seconds = 10.0;
};

/// Counters shared by all sessions. Thread-safe.
class Figures {
 public:
  void add(double microseconds) {
    const std::lock_guard lock(mutex_);
    microseconds_.push_back(microseconds);
  }
  void fail(const std::string& message) {
    const std::lock_guard lock(mutex_);
    if (problem_.empty()) {
      problem_ = message;
    }
  }
  void sort() { std::sort(microseconds_.begin(), microseconds_.end()); }
  [[nodiscard]] std::size_t count() const { return microseconds_.size(); }
  /// The percentile `share` of the times, after sort(). Zero when there are no times.
  [[nodiscard]] double percentile(std::size_t share) const {
    return microseconds_.empty() ? 0.0 : microseconds_[(microseconds_.size() - 1) * share / 100];
  }
  [[nodiscard]] const std::string& problem() const { return problem_; }

  std::atomic<std::uint64_t> frames{0};
  std::atomic<std::uint64_t> differences{0};  // frames that hold only changes
  std::atomic<std::uint64_t> frameBytes{0};
  std::atomic<bool> isOver{false};

 private:
  std::mutex mutex_;
  std::vector<double> microseconds_;  // of each step
  std::string problem_;               // the first
};

ConnectionPointer connect(const LoadOptions& options, Figures& figures) {
  client::ClientOptions clientOptions;
  clientOptions.name = "espalier load";
  clientOptions.token = options.token;
  auto connected = connectTo(options.server, clientOptions);
  if (!connected) {
    figures.fail(connected.error());
    return nullptr;
  }
  return std::make_unique<ServerConnection>(std::move(*connected));
}

/// The result, or nothing when the figures have the problem.
std::optional<std::string> ask(client::Client& client, std::string_view method, const std::string& params,
                               Figures& figures) {
  const auto answer = client.request(method, params);
  if (!answer) {
    figures.fail(std::string(method) + ": " + answer.error().message);
    return std::nullopt;
  }
  return *answer;
}

std::string named(const std::string& simulation, const std::string& more = {}) {
  protocol::JsonWriter params;
  params.beginObject().key("simulation").text(simulation);
  if (!more.empty()) {
    params.raw(more);
  }
  return params.endObject().take();
}

/// A plant with `queries` communication modules that grows slowly.
std::string createParams(unsigned queries) {
  std::string source = "Lsystem: 1\nderivation length: 1000000000\nAxiom: A(0)";
  for (unsigned i = 0; i < queries; ++i) {
    source += "[+(" + std::to_string(i * 7) + ")F(1)?E(0)]";
  }
  source += "\nA(n) : n == 100 --> F(1)A(0)\nA(n) --> A(n+1)\nendlsystem\n";
  protocol::JsonWriter params;
  params.beginObject().key("model").beginObject().key("source").text(source).endObject();
  params.key("name").text("load").key("save").boolean(false);
  return params.key("environment").raw(R"([{"type":"height"}])").endObject().take();
}

void step(client::Client& client, const std::string& simulation, Figures& figures) {
  const std::string params = named(simulation);
  while (!figures.isOver) {
    const auto begin = Clock::now();
    if (!ask(client, "simulation.step", params, figures)) {
      return;
    }
    figures.add(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
  }
}

void watch(const LoadOptions& options, const std::string& simulation, Figures& figures) {
  const ConnectionPointer connection = connect(options, figures);
  if (connection == nullptr || !ask(*connection->client, "stream.open",
                                    named(simulation, R"("what":"turtle","delta":true,"bin":true)"), figures)) {
    return;
  }
  while (!figures.isOver && connection->client->isOpen()) {
    const auto frame = connection->client->nextNotification(std::chrono::milliseconds(100));
    if (!frame || frame->method != "stream.data") {
      continue;
    }
    ++figures.frames;
    figures.differences += protocol::memberOf(frame->paramsJson, "key") == "false" ? 1 : 0;
    std::uint64_t bytes = frame->paramsJson.size();
    if (const protocol::Blocks* const blocks = frame->params.blocks()) {
      for (const protocol::BlockDescription& block : blocks->descriptions()) {
        bytes += block.bytes;
      }
    }
    figures.frameBytes += bytes;
  }
}

int runLoad(const LoadOptions& options) {
  Figures figures;
  std::vector<ConnectionPointer> controllers;
  std::vector<ConnectionPointer> idle;
  std::vector<std::string> simulations;
  for (unsigned i = 0; i < options.idle && figures.problem().empty(); ++i) {
    idle.push_back(connect(options, figures));
  }
  for (unsigned i = 0; i < options.sessions && figures.problem().empty(); ++i) {
    controllers.push_back(connect(options, figures));
    if (controllers.back() != nullptr) {
      const auto created =
          ask(*controllers.back()->client, "simulation.create", createParams(options.queries), figures);
      simulations.push_back(created ? protocol::memberOf(*created, "simulation").value_or("") : std::string());
    }
  }
  const auto begin = Clock::now();
  if (figures.problem().empty()) {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < controllers.size(); ++i) {
      threads.emplace_back([&, i] { step(*controllers[i]->client, simulations[i], figures); });
    }
    for (unsigned i = 0; i < options.viewers; ++i) {
      threads.emplace_back([&, i] { watch(options, simulations[i % simulations.size()], figures); });
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(options.seconds));
    figures.isOver = true;
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  for (std::size_t i = 0; i < simulations.size(); ++i) {
    if (!simulations[i].empty()) {
      (void)ask(*controllers[i]->client, "simulation.delete", named(simulations[i]), figures);
    }
  }
  if (!figures.problem().empty()) {
    printError(figures.problem());
    return kFailure;
  }
  figures.sort();
  const double steps = static_cast<double>(figures.count());
  std::printf("%-30s %.0f\n%-30s %.0f\n", "steps/s", steps / seconds, "queries/s", steps * options.queries / seconds);
  std::printf("%-30s %.0f\n%-30s %.0f\n%-30s %.0f\n", "step, median (us)", figures.percentile(50),
              "step, 99 of 100 (us)", figures.percentile(99), "step, longest (us)", figures.percentile(100));
  if (options.viewers > 0) {
    const auto frames = static_cast<double>(figures.frames);
    const auto share = [frames](std::uint64_t count) { return frames > 0 ? static_cast<double>(count) / frames : 0.0; };
    std::printf("%-30s %.0f\n", "frames/s", frames / seconds);
    std::printf("%-30s %.1f\n", "of 100 frames, differences", 100.0 * share(figures.differences));
    std::printf("%-30s %.0f\n", "bytes a frame", share(figures.frameBytes));
  }
  return kSuccess;
}

}  // namespace

void addLoad(CLI::App& program, int& status) {
  const auto options = std::make_shared<LoadOptions>();
  CLI::App* command = program.add_subcommand("load", "Put a running server under load and measure its answers");
  addServerAddress(*command, options->server, false);
  addClientToken(*command, options->token);
  command->add_option("--sessions", options->sessions, "Sessions; each steps its own simulation")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  command->add_option("--viewers", options->viewers, "Viewers, spread over the simulations")
      ->check(CLI::Range(0, 10'000))
      ->capture_default_str();
  command->add_option("--idle", options->idle, "Sessions that connect and send nothing")
      ->check(CLI::Range(0, 100'000))
      ->capture_default_str();
  command->add_option("--queries", options->queries, "Communication modules of each plant")
      ->check(CLI::Range(0, 100'000))
      ->capture_default_str();
  command->add_option("--seconds", options->seconds, "Duration of the measurement, in seconds")
      ->check(numberFrom(0.01, 86'400.0))
      ->capture_default_str();
  command->footer(
      "The command deletes its simulations at the end. Exit status: 0 every call was answered, 1 a call failed.\n"
      "Example: espalier load 127.0.0.1:4321 --sessions 8 --viewers 50 --idle 900");
  command->callback([options, &status] { status = runLoad(*options); });
}

}  // namespace espalier::command

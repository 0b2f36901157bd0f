#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "clients/cpp/client.h"
#include "protocol/json_text.h"
#include "protocol/json_writer.h"
#include "server/server.h"

namespace espalier::server {

/// A folder that is removed with its owner.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "espalier-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// A server on a free port that runs in a thread.
class RunningServer {
 public:
  explicit RunningServer(ServerOptions options = {}) {
    options.port = 0;
    options.logLevel = "off";
    options.workers = options.workers == 0 ? 2 : options.workers;
    server_ = std::make_unique<Server>(std::move(options));
    const auto problem = server_->listen();
    EXPECT_FALSE(problem.has_value()) << problem.value_or("");
    thread_ = std::thread([this] { server_->run(false); });
  }
  ~RunningServer() { stop(); }
  void stop() {
    if (thread_.joinable()) {
      server_->stop();
      thread_.join();
    }
  }
  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(server_->port()); }
  /// Of the HTTP side, for options with a host for it.
  [[nodiscard]] std::string httpAddress() const { return "127.0.0.1:" + std::to_string(server_->httpPort()); }

 private:
  std::unique_ptr<Server> server_;
  std::thread thread_;
};

/// The client or a failed test.
inline std::unique_ptr<client::Client> connectTo(const RunningServer& server, client::ClientOptions options = {}) {
  options.requestTimeout = std::chrono::seconds(60);
  auto connected = client::Client::connect(server.address(), options);
  if (!connected) {
    ADD_FAILURE() << connected.error().message;
    return nullptr;
  }
  return std::move(connected.value());
}

/// The result, or a failed test.
inline std::string resultOf(const client::Outcome& outcome) {
  if (!outcome) {
    ADD_FAILURE() << "error " << static_cast<int>(outcome.error().code) << ": " << outcome.error().message;
    return "{}";
  }
  return outcome.value();
}

/// The error, or a failed test.
inline protocol::Error errorOf(const client::Outcome& outcome) {
  if (outcome) {
    ADD_FAILURE() << "a result where an error was expected: " << *outcome;
    return {};
  }
  return outcome.error();
}

inline std::string member(const std::string& json, std::string_view name) {
  return protocol::memberOf(json, name).value_or("(no " + std::string(name) + ")");
}

/// A growing axis that the environment stops: the query's answer replaces h.
inline constexpr std::string_view kGrowth =
    "Lsystem: 1\nderivation length: 6\nAxiom: F(1)A?E(0)\n"
    "A > ?E(h) : h < 3 --> F(1)A\nA > ?E(h) : h >= 3 --> *\nendlsystem\n";

/// simulation.create of a source with an environment array (JSON text; empty: none) and further members.
inline std::string createParams(std::string_view source, std::string_view environment = {},
                                std::string_view more = {}) {
  protocol::JsonWriter params;
  params.beginObject().key("model").beginObject().key("source").text(source).endObject();
  if (!environment.empty()) {
    params.key("environment").raw(environment);
  }
  if (!more.empty()) {
    params.raw(more);
  }
  return params.endObject().take();
}

inline std::string create(client::Client& client, std::string_view source, std::string_view environment = {},
                          std::string_view more = {}) {
  return member(resultOf(client.request("simulation.create", createParams(source, environment, more))), "simulation");
}

inline std::string named(const std::string& simulation, std::string_view more = {}) {
  protocol::JsonWriter params;
  params.beginObject().key("simulation").text(simulation);
  if (!more.empty()) {
    params.raw(more);
  }
  return params.endObject().take();
}

inline std::string stringOf(client::Client& client, const std::string& simulation) {
  return member(resultOf(client.request("simulation.get", named(simulation, R"("what":"string")"))), "string");
}

/// An environment that offers itself and answers in a thread of its own: with the query's y coordinate as first
/// parameter, unless `answer` says otherwise.
class OfferingEnvironment {
 public:
  using Answer = std::function<void(client::Client&, const client::IncomingRequest&)>;
  OfferingEnvironment(const RunningServer& server, const std::string& name, Answer answer)
      : client_(connectTo(server)) {
    resultOf(client_->request("environment.offer", R"({"name":")" + name + R"("})"));
    thread_ = std::thread([this, answer = std::move(answer)] {
      while (!isStopped_ && client_->isOpen()) {
        if (const auto request = client_->nextRequest(std::chrono::milliseconds(20))) {
          answer(*client_, *request);
        }
      }
    });
  }
  ~OfferingEnvironment() {
    isStopped_ = true;
    thread_.join();
  }

 private:
  std::unique_ptr<client::Client> client_;
  std::atomic<bool> isStopped_{false};
  std::thread thread_;
};

}  // namespace espalier::server

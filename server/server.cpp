#include "server/server.h"

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <thread>

#include "server/network/network.h"
#include "server/server_core.h"

namespace espalier::server {
namespace {

/// After stop(): the time for running steps, and then for the last lines of each connection.
constexpr std::chrono::milliseconds kPatienceForSteps{10'000};
constexpr std::chrono::milliseconds kPatienceForConnections{2'000};

}  // namespace

class Server::Implementation {
 public:
  explicit Implementation(ServerOptions options) : core_(std::move(options)), network_(core_) {}

  ~Implementation() {
    if (closer_.joinable()) {
      closer_.join();
    }
    // a worker may still hold a connection, which must not outlive the network
    core_.waitForWorkers();
  }

  std::optional<std::string> listen() {
    const ServerOptions& options = core_.options();
    for (const std::string& host : {options.host, options.httpHost}) {
      if (auto problem = problemOfHost(host)) {
        return problem;
      }
    }
    std::error_code error;
    if (!options.galleryFolder.empty() && !std::filesystem::is_directory(options.galleryFolder, error)) {
      return "there is no gallery folder '" + options.galleryFolder +
             "': give --gallery a folder of model folders, or leave it out.";
    }
    if (!options.modelsFolder.empty() && !std::filesystem::is_directory(options.modelsFolder, error)) {
      return "there is no folder '" + options.modelsFolder +
             "' for models: make it, or give --models another one, or leave it out.";
    }
    // taking the port first: a second server on the same data folder and port stops here
    if (auto problem = network_.listen()) {
      return problem;
    }
    return core_.loadSaved();
  }

  [[nodiscard]] std::uint16_t port() const { return network_.port(); }
  [[nodiscard]] std::uint16_t httpPort() const { return network_.httpPort(); }

  void run(bool handleSignals) {
    const std::string& host = core_.options().host;
    core_.log().info("serving on " + (host.starts_with("unix:") ? host : host + ":" + std::to_string(port())));
    network_.run(handleSignals, [this] { stop(); });
    // stop() may not have stored its thread yet
    std::thread closer;
    {
      const std::lock_guard lock(mutex_);
      closer = std::move(closer_);
    }
    if (closer.joinable()) {
      closer.join();
    }
    core_.log().info("stopped");
    if (isStuck_ && handleSignals) {
      // complete work is saved; the destructors would wait for the work that does not end
      core_.log().error("something computes that does not end; the process ends without it");
      std::_Exit(EXIT_SUCCESS);
    }
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    if (isStopping_) {
      return;
    }
    isStopping_ = true;
    core_.log().info("stopping: running steps are finished");
    network_.stopAccepting();
    network_.announceShutdown();
    core_.beginShutdown();
    // the network goes on meanwhile: running steps may need answers of connected environments
    closer_ = std::thread([this] {
      isStuck_ = !core_.finishRunning(kPatienceForSteps);
      network_.close(kPatienceForConnections);
    });
  }

 private:
  /// Why the server may not listen on a host, or nothing.
  [[nodiscard]] std::optional<std::string> problemOfHost(const std::string& host) const {
    const ServerOptions& options = core_.options();
    if (host.empty() || Network::isLoopback(host)) {
      return std::nullopt;
    }
    if (options.tokens.empty()) {
      return "'" + host +
             "' can be reached from other machines: give a token that clients must send (--token TEXT or --token-file "
             "FILE), or listen on 127.0.0.1.";
    }
    if (options.certificateFile.empty() && !options.isInsecureAllowed) {
      return "'" + host +
             "' can be reached from other machines and the connection is not encrypted: give --certificate FILE and "
             "--key FILE, add --insecure if that is acceptable, or listen on 127.0.0.1 and use an SSH tunnel.";
    }
    return std::nullopt;
  }

  ServerCore core_;
  Network network_;
  std::mutex mutex_;
  bool isStopping_ = false;
  std::thread closer_;
  std::atomic<bool> isStuck_{false};  // something computed on after stop()
};

Server::Server(ServerOptions options) : implementation_(std::make_unique<Implementation>(std::move(options))) {}
Server::~Server() = default;

std::optional<std::string> Server::listen() {
  return implementation_->listen();
}

std::uint16_t Server::port() const {
  return implementation_->port();
}

std::uint16_t Server::httpPort() const {
  return implementation_->httpPort();
}

void Server::run(bool handleSignals) {
  implementation_->run(handleSignals);
}

void Server::stop() {
  implementation_->stop();
}

}  // namespace espalier::server

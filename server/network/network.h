#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace espalier::server {

class ServerCore;

/// The listeners and their connections. Everything runs on the thread that called run(), "the network thread". It
/// reads, decodes small messages and writes; a worker makes every step.
class Network {
 public:
  explicit Network(ServerCore& core);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  /// Binds and listens where the server's options say; an error sentence when that is not possible.
  [[nodiscard]] std::optional<std::string> listen();
  /// The port of the listener for the protocol; 0: a Unix socket.
  [[nodiscard]] std::uint16_t port() const;
  /// The port of the HTTP side; 0: there is none.
  [[nodiscard]] std::uint16_t httpPort() const;
  /// Whether every address that the name stands for is of this machine only; unix:PATH is.
  [[nodiscard]] static bool isLoopback(const std::string& host);

  /// Serves until close() has done its work. `onStop` is called on this thread for each SIGINT or SIGTERM when
  /// `handleSignals`.
  void run(bool handleSignals, std::function<void()> onStop);
  /// Accepts nobody any more. Thread-safe.
  void stopAccepting();
  /// Sends every session the notification server.shutdown. Thread-safe.
  void announceShutdown();
  /// Closes all connections when what is queued has been sent, at the latest after `patience`; then run() returns.
  /// Thread-safe.
  void close(std::chrono::milliseconds patience);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace espalier::server

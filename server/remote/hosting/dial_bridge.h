#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <variant>

namespace espalier::server {

/// A way to a server over TLS, a WebSocket, both, or a socket of the file system, for a client that speaks lines over
/// TCP: a port of this machine that takes one connection and passes on what comes. A thread of its own; it ends with
/// the object, or when either side does.
class DialBridge {
 public:
  struct Options {
    std::string trustedFile;  // certificates (PEM) that are trusted besides the system's; empty: none
    std::chrono::milliseconds connectTimeout{5'000};
  };

  /// Whether an address is one of those: tls://HOST:PORT, ws://HOST:PORT, wss://HOST:PORT, unix:PATH.
  [[nodiscard]] static bool isFor(const std::string& address);
  /// Connects and greets (TLS, upgrade). An error sentence when that fails.
  [[nodiscard]] static std::variant<std::unique_ptr<DialBridge>, std::string> open(const std::string& address,
                                                                                   const Options& options);
  ~DialBridge();
  DialBridge(const DialBridge&) = delete;
  DialBridge& operator=(const DialBridge&) = delete;

  /// HOST:PORT for the client.
  [[nodiscard]] std::string address() const;

 private:
  class Implementation;
  explicit DialBridge(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace espalier::server

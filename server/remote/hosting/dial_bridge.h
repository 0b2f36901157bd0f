#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <tl/expected.hpp>

namespace espalier::server {

/// Lets a client that speaks lines over TCP reach a server over TLS, a WebSocket, both, or a Unix socket. It is a port
/// of this machine that takes one connection and passes the bytes on. Its thread ends with the object, or when either
/// side closes.
class DialBridge {
 public:
  struct Options {
    std::string trustedFile;  // certificates (PEM) that are trusted besides the system's; empty: none
    std::chrono::milliseconds connectTimeout{5'000};
  };

  /// Whether an address is one of those: tls://HOST:PORT, ws://HOST:PORT, wss://HOST:PORT, unix:PATH.
  [[nodiscard]] static bool isFor(const std::string& address);
  /// Connects and greets (TLS, upgrade). An error sentence when that fails.
  [[nodiscard]] static tl::expected<std::unique_ptr<DialBridge>, std::string> open(const std::string& address,
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

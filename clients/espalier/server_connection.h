#pragma once

#include <memory>
#include <string>

#include "clients/cpp/client.h"
#include "clients/espalier/result.h"
#include "server/remote/hosting/dial_bridge.h"

namespace CLI {
class App;
}

namespace espalier::command {

/// Where a server is, as `connect`, `status` and `load` take it.
struct ServerAddress {
  std::string address = "127.0.0.1:4321";  // HOST:PORT, tls://, unix:PATH, ws:// or wss://
  std::string trustedFile;                 // empty: the certificates of the system
};

/// A connection to a server over any transport.
struct ServerConnection {
  std::unique_ptr<server::DialBridge> bridge;  // null: none is needed. It outlives the client
  std::unique_ptr<client::Client> client;
};

/// Adds `address` and --trust.
void addServerAddress(CLI::App& command, ServerAddress& address, bool isRequired);

/// Connects and says hello; a sentence with a remedy when that fails.
[[nodiscard]] Result<ServerConnection> connectTo(const ServerAddress& address, const client::ClientOptions& options);

}  // namespace espalier::command

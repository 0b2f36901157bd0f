#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/token.h"
#include "server/remote/limits.h"
#include "server/remote/remote_permissions.h"
#include "server/store/durability.h"

namespace espalier::server {

/// A file that the HTTP side gives to browsers.
struct WebFile {
  std::string path;           // "/" is the front page
  std::string type;           // Content-Type
  std::string_view content;   // must outlive the server, like `packed`
  std::string_view packed{};  // the same compressed by gzip; empty: it is only sent as it is
  std::string policy{};       // Content-Security-Policy; empty: that of the server's own page
  std::string tag{};          // ETag, by the content; the server gives it
};

struct ServerOptions {
  std::string host = "127.0.0.1";  // or unix:PATH: a socket of this machine's file system
  std::uint16_t port = 0;          // 0: a free one
  std::string httpHost;            // empty: no HTTP side
  std::uint16_t httpPort = 0;      // 0: a free one
  std::string certificateFile;     // PEM; with a key: connections are encrypted
  std::string keyFile;
  std::vector<WebFile> pages;               // beside /health and /metrics
  std::vector<std::string> allowedOrigins;  // of pages that may open WebSockets, beside the server's own
  std::string dataFolder;                   // empty: simulations are not saved
  Durability durability = Durability::Process;
  std::string galleryFolder;  // empty: no gallery models by name
  std::string modelsFolder;   // of models that clients save; empty: none
  std::vector<Token> tokens;  // none: clients need none; any address but loopback needs one
  struct ReadAgain {
    std::vector<Token> tokens{};
    std::optional<ServerLimits> limits{};    // none: they stay
    std::vector<std::string> restartKeys{};  // of the configuration: changed, but read only at start
  };
  /// Reads tokens and limits again when SIGHUP comes, on a worker. After an error sentence all stay as they are. Null:
  /// nothing is read again but a certificate; without one SIGHUP stops the server.
  std::function<tl::expected<ReadAgain, std::string>()> readAgain;
  /// Called once, when the server serves and handles signals. Null: nothing.
  std::function<void()> readySignal;
  /// Called on the network thread about once a second while the server serves. Null: nothing.
  std::function<void()> aliveSignal;
  bool isInsecureAllowed = false;  // a non-loopback address without TLS
  RemotePermissions remote;        // environments in other processes that clients may name
  unsigned workers = 0;            // 0: processorCount() of server/remote/control_group.h
  unsigned threads = 1;            // of one step; the plant is the same for any number
  ServerLimits limits;             // at start
  std::string logLevel = "info";   // trace debug info warn error off
  std::string logFormat = "text";  // text or json
};

/// The server. run() blocks until stop() (from any thread or a signal) and shuts down cleanly: sessions are told,
/// running steps finish, simulations are saved.
class Server {
 public:
  explicit Server(ServerOptions options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Binds and listens. An error sentence that says what to do (port in use, not loopback without token), or nothing.
  [[nodiscard]] std::optional<std::string> listen();
  [[nodiscard]] std::uint16_t port() const;
  /// The port of the HTTP side; 0: there is none.
  [[nodiscard]] std::uint16_t httpPort() const;
  /// Serves until stopped. `handleSignals`: SIGINT and SIGTERM stop it. SIGHUP reads tokens, limits and certificate
  /// again where there is readAgain or a certificate; else it stops the server, unless it is ignored (nohup).
  void run(bool handleSignals);
  void stop();

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace espalier::server

#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/envelope.h"
#include "protocol/errors.h"
#include "protocol/framing.h"

namespace espalier::client {

struct ClientOptions {
  std::string name = "espalier-client";  // for the server's log
  std::string version = "0.1.0";
  std::vector<std::string> roles{"controller", "viewer"};  // that are asked for; the token grants those that it has
  std::string token;                                       // empty: none
  std::chrono::milliseconds connectTimeout{5'000};
  std::chrono::milliseconds requestTimeout{600'000};
  protocol::FrameLimits limits;
  std::vector<std::string> capabilities{"bin", "strict"};  // binary blocks; unknown members are errors
};

/// A notification of the server: stream.data, stream.end, server.shutdown.
struct Notification {
  std::string method;
  std::string paramsJson;
  protocol::Payload params;  // with its blocks
};

/// A request of the server to an environment that this client offers.
struct IncomingRequest {
  protocol::MessageId id;
  std::string method;
  protocol::Payload params;
};

/// The result's JSON text, or the error of the server or of the connection.
using Outcome = protocol::Expected<std::string>;

/// A connection to an Espalier server. Calls wait for their answers. For one thread.
///
///     auto client = Client::connect("127.0.0.1:4321", {});
///     if (!client) { use client.error().message }
///     auto created = (*client)->request("simulation.create", R"({"model":{"gallery":"tree"}})");
class Client {
 public:
  /// Connects and says hello.
  [[nodiscard]] static protocol::Expected<std::unique_ptr<Client>> connect(const std::string& address,
                                                                           const ClientOptions& options);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// The server's answer to hello, as JSON.
  [[nodiscard]] const std::string& helloResult() const;

  /// Asks and waits for the answer. Notifications and requests that come meanwhile are kept for the functions below. A
  /// lost connection is an error with the code Internal; a missing answer has the code Timeout.
  [[nodiscard]] Outcome request(std::string_view method, std::string_view paramsJson);

  /// Sends without waiting; returns the id to give to waitFor or cancel.
  [[nodiscard]] protocol::Expected<std::int64_t> send(std::string_view method, std::string_view paramsJson);
  [[nodiscard]] Outcome waitFor(std::int64_t id, std::chrono::milliseconds timeout);
  [[nodiscard]] std::optional<protocol::Error> notify(std::string_view method, std::string_view paramsJson);

  /// The next notification, or nothing when the time is over or the connection closed (isOpen tells).
  [[nodiscard]] std::optional<Notification> nextNotification(std::chrono::milliseconds timeout);
  /// The next request of the server, to be answered with respond or respondError.
  [[nodiscard]] std::optional<IncomingRequest> nextRequest(std::chrono::milliseconds timeout);
  [[nodiscard]] std::optional<protocol::Error> respond(const protocol::MessageId& id, const protocol::Body& result);
  [[nodiscard]] std::optional<protocol::Error> respondError(const protocol::MessageId& id,
                                                            const protocol::Error& error);

  [[nodiscard]] bool isOpen() const;
  void close();

 private:
  class Implementation;
  explicit Client(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace espalier::client

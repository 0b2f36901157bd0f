#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <memory>
#include <optional>
#include <string>

#include "clients/cpp/client.h"

namespace espalier::client {

/// A connection to an Espalier server for programs that run an Asio context. Every call is a coroutine, and many calls
/// may run at once. Use it from one thread, or from one strand. A coroutine that is cancelled while it waits for an
/// answer (as by asio's `||`) cancels the request on the server. A simulation then stays at its last completed step.
///
///     asio::awaitable<void> grow() {
///       auto client = co_await CoroutineClient::connect("127.0.0.1:4321");
///       if (!client) { co_return; }  // client.error().message says why
///       auto created = co_await (*client)->request("simulation.create", R"({"model":{"gallery":"branch-tiers"}})");
///     }
///     asio::io_context context;
///     asio::co_spawn(context, grow(), asio::detached);
///     context.run();
class CoroutineClient {
 public:
  using Connected = protocol::Expected<std::unique_ptr<CoroutineClient>>;

  /// Connects and says hello, on the executor of the coroutine that calls.
  [[nodiscard]] static boost::asio::awaitable<Connected> connect(std::string address, ClientOptions options);
  /// The same with the default options. (g++ 12 cannot compile `co_await connect(address, {})`.)
  [[nodiscard]] static boost::asio::awaitable<Connected> connect(std::string address);
  /// Closes the connection; calls under way end with an error.
  ~CoroutineClient();
  CoroutineClient(const CoroutineClient&) = delete;
  CoroutineClient& operator=(const CoroutineClient&) = delete;

  /// The server's answer to hello, as JSON.
  [[nodiscard]] const std::string& helloResult() const;

  /// Asks and waits for the answer, at most `requestTimeout` of the options. A lost connection is an error with the
  /// code Internal, a missing answer one with Timeout.
  [[nodiscard]] boost::asio::awaitable<Outcome> request(std::string method, std::string paramsJson);
  /// Queues a message that has no answer. The next request reports a failure to send it.
  void notify(std::string_view method, std::string_view paramsJson);

  /// The next notification (a frame of a stream), or nothing once the connection has closed.
  [[nodiscard]] boost::asio::awaitable<std::optional<Notification>> nextNotification();
  /// The next request of the server to an environment that this client offers, to be answered with respond or
  /// respondError; nothing once the connection has closed.
  [[nodiscard]] boost::asio::awaitable<std::optional<IncomingRequest>> nextRequest();
  void respond(const protocol::MessageId& id, const protocol::Body& result);
  void respondError(const protocol::MessageId& id, const protocol::Error& error);

  [[nodiscard]] bool isOpen() const;
  void close();

 private:
  class State;
  explicit CoroutineClient(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

}  // namespace espalier::client

#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "clients/cpp/client.h"

namespace espalier::client {

/// A connection to an Espalier server for programs that run an Asio context: every call is a coroutine, and any number
/// of them may be under way at once. Use it from one thread, or from one strand. A coroutine that is cancelled while it
/// waits for an answer (as by asio's `||`) cancels the request on the server: a simulation then stays at its last
/// completed step.
///
///     asio::awaitable<void> grow() {
///       auto connected = co_await CoroutineClient::connect("127.0.0.1:4321");
///       auto client = std::get<std::unique_ptr<CoroutineClient>>(std::move(connected));
///       auto created = co_await client->request("simulation.create", R"({"model":{"gallery":"branch-tiers"}})");
///     }
///     asio::io_context context;
///     asio::co_spawn(context, grow(), asio::detached);
///     context.run();
class CoroutineClient {
 public:
  using Connected = std::variant<std::unique_ptr<CoroutineClient>, protocol::Error>;

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
  /// Sends without an answer. Queued; what cannot be sent is seen by the next request.
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

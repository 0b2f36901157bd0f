#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "clients/cpp/client.h"

namespace espalier::client {

// Shared by the blocking client and the coroutine client.

using Clock = std::chrono::steady_clock;

/// Where a server listens.
struct Address {
  std::string host;
  std::string port;
};

/// The address of HOST:PORT; an IPv6 host may be in square brackets.
[[nodiscard]] protocol::Expected<Address> parseAddress(const std::string& address);

[[nodiscard]] protocol::Error notReached(const std::string& address, const std::string& reason);
[[nodiscard]] protocol::Error lostConnection(const std::string& reason);
[[nodiscard]] protocol::Error lateAnswer(std::string_view what, std::chrono::milliseconds timeout);

/// One side of a connection, without the socket. Sorts received bytes into answers, notifications and requests.
class Conversation {
 public:
  explicit Conversation(ClientOptions options) : options_(std::move(options)), reader_(options_.limits) {}

  [[nodiscard]] const ClientOptions& options() const { return options_; }
  /// The params of hello.
  [[nodiscard]] std::string helloJson() const;
  /// Takes in the server's answer to hello: blocks are accepted when it named them too.
  void agree(std::string helloResult);
  [[nodiscard]] const std::string& helloResult() const { return helloResult_; }

  /// The id of the next request.
  [[nodiscard]] std::int64_t nextId() { return ++lastId_; }

  void feed(std::string_view bytes) { reader_.feed(bytes); }
  /// Sorts one received message. False when there is none, or when the framing is lost (`broken`).
  bool takeMessage();
  /// The reason why later messages cannot be read, or nothing.
  [[nodiscard]] std::optional<std::string> broken() const;

  /// Takes out the answer to a request.
  [[nodiscard]] std::optional<Outcome> takeAnswer(std::int64_t id);
  [[nodiscard]] bool hasAnswer(std::int64_t id) const { return answers_.contains(id); }
  /// An answer that comes later is dropped.
  void forget(std::int64_t id) { forgotten_.insert(id); }
  [[nodiscard]] std::optional<Notification> takeNotification();
  [[nodiscard]] std::optional<IncomingRequest> takeRequest();

  /// An error without id: why the server closes.
  [[nodiscard]] const std::optional<protocol::Error>& refusal() const { return refusal_; }

 private:
  ClientOptions options_;
  protocol::MessageReader reader_;
  std::string helloResult_;
  std::map<std::int64_t, Outcome> answers_;  // by request, not yet taken
  std::set<std::int64_t> forgotten_;         // requests whose late answers are dropped
  std::deque<Notification> notifications_;
  std::deque<IncomingRequest> requests_;
  std::optional<protocol::Error> refusal_;
  std::int64_t lastId_ = 0;
};

}  // namespace espalier::client

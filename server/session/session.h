#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "protocol/framing.h"
#include "protocol/messages.h"
#include "server/access/access.h"
#include "server/remote/offered_environments.h"
#include "server/running/simulation_runner.h"
#include "server/session/connection.h"
#include "server/stream/stream.h"

namespace espalier::server {

class Account;
class EditorConversation;
class ServerCore;

/// One peer: handshake, its requests in progress, its streams, and the questions put to it when it offers environments.
/// Messages come one at a time, on the network thread or, when they are big, on a worker. Answers may come from any
/// thread.
class Session final : public AskedPeer, public std::enable_shared_from_this<Session> {
 public:
  Session(std::string id, ServerCore& core, std::shared_ptr<Connection> connection);
  ~Session() override;

  // network thread, but for onRead(): one message at a time, big ones on a worker
  /// `bytes`: of the message, counted for the account until a request is answered. 0: holdForRequest() follows.
  void onRead(const protocol::MessageReader::Read& read, std::size_t bytes = 0);
  /// So many bytes of a request's message stay until it is answered. On the thread of onRead(), after it.
  void holdForRequest(const protocol::MessageId& id, std::size_t bytes);
  /// The framing is lost: tells the peer the reason and closes the connection.
  void onLost(const protocol::Error& error);
  void onHandshakeTimeout();
  /// A heartbeat has passed. `wasHeard`: something came from the peer meanwhile. Returns false to give the peer up: it
  /// was asked and has been silent for a whole heartbeat. A peer that computes a step is not asked.
  [[nodiscard]] bool onHeartbeat(bool wasHeard);
  /// Whether the peer's token still holds. When it does not, the peer is told and the connection closes.
  [[nodiscard]] bool checkAccess();
  /// Part of the outbox was sent: streams may have room again.
  void onDrained();
  /// The peer sends no more: its answers will not come. It may still read the answers to its own requests.
  void onPeerEnded();
  /// A request of the peer is not answered yet.
  [[nodiscard]] bool isAnswering() const;
  /// May be called again, for what a message began that was being handled meanwhile.
  void onClosed();
  [[nodiscard]] bool isGreeted() const { return isGreeted_; }
  /// Both sides named the capability `bin`.
  [[nodiscard]] bool areBlocksAgreed() const { return isGreeted_ && terms().takesBlocks; }

  // any thread
  void respond(const protocol::MessageId& id, std::string_view resultJson);
  void respondError(const protocol::MessageId& id, const protocol::Error& error);
  /// Unknown members of a request are errors: the peer named the capability `strict`.
  [[nodiscard]] bool isStrict() const;
  /// Adds sentences that the answer to a request will have as `warnings`.
  void warn(const protocol::MessageId& id, std::vector<std::string> warnings);
  void notify(std::string_view method, const protocol::Body& params);
  /// Calls onDrained() when that time has passed.
  void remind(std::chrono::milliseconds delay) { connection_->remind(delay); }
  [[nodiscard]] std::size_t outboxBytes() const { return connection_->outboxBytes(); }
  [[nodiscard]] std::string ask(std::string_view method, const protocol::Body& params,
                                std::shared_ptr<PendingCall> call) override;
  [[nodiscard]] PeerTerms terms() const override;
  void forget(const std::string& id) override;
  [[nodiscard]] std::string owner() const override { return std::string(tokenName()); }
  [[nodiscard]] bool hasMissedHeartbeat() const override;

  // for the handlers (methods.h), on the thread of onRead()
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] ServerCore& core() { return *core_; }
  /// The roles of a peer that has said hello.
  [[nodiscard]] const protocol::Roles& roles() const { return grant_.roles; }
  /// The name of the peer's token. Empty: the server has no tokens.
  [[nodiscard]] std::string_view tokenName() const {
    return grant_.token == nullptr ? std::string_view() : std::string_view(grant_.token->name);
  }
  /// The account in which the peer's requests count.
  [[nodiscard]] Account& account() const;
  /// Sends a command to a simulation as the work of a request, so that $/cancel and a lost connection reach it.
  void submit(const protocol::MessageId& id, std::shared_ptr<SimulationRunner> runner,
              std::shared_ptr<Command> command);
  /// How a request in progress is given up when it is cancelled or its connection is lost.
  void onCancel(const protocol::MessageId& id, std::function<void()> cancel);
  void cancelRequest(const protocol::MessageId& id);
  /// The peer's conversation of the Language Server Protocol; it begins with the first call.
  [[nodiscard]] std::shared_ptr<EditorConversation> editor();
  /// An error when the session, or its account, has as many streams as it may have.
  [[nodiscard]] protocol::Expected<std::shared_ptr<Stream>> openStream(protocol::StreamOpenParams params,
                                                                       SimulationRunner& runner);
  [[nodiscard]] std::shared_ptr<Stream> findStream(const std::string& id);
  [[nodiscard]] bool closeStream(const std::string& id);

 private:
  void onMessage(const protocol::Message& message, std::size_t bytes);
  /// Memory of the account, given back with the last reference. An error when the account does not have it.
  [[nodiscard]] protocol::Expected<std::shared_ptr<void>> reserve(MemoryKind kind, std::size_t bytes);
  void onAnswer(const protocol::Message& message);
  void onHello(const protocol::Message& message);
  /// Refuses and closes.
  void refuse(const protocol::MessageId& id, const protocol::Error& error);
  /// The answer with the warnings of its request; empty: there are none.
  [[nodiscard]] std::string withWarnings(const protocol::MessageId& id, std::string_view resultJson);
  void failPendingCalls(const LinkFailure& failure);
  void send(std::string line);

  const std::string id_;
  ServerCore* core_;
  std::shared_ptr<Connection> connection_;
  bool isGreeted_ = false;              // network thread
  std::uint32_t linesBeforeHello_ = 0;  // the same
  Grant grant_;                         // does not change after hello
  mutable std::mutex mutex_;            // guards the members below
  bool isClosed_ = false;
  bool isEnded_ = false;          // the peer answers nothing more
  bool isStrict_ = false;         // it named the capability
  bool takesHeartbeats_ = false;  // it named the capability
  bool isHeartbeatOwed_ = false;  // it was asked and has been silent since
  std::uint64_t heartbeatCount_ = 0;
  PeerTerms terms_;
  std::uint64_t askedCount_ = 0;
  std::uint64_t streamCount_ = 0;
  std::map<std::string, std::shared_ptr<PendingCall>> pending_;  // questions to the peer, by id
  std::shared_ptr<EditorConversation> editor_;
  struct InProgress {
    std::function<void()> cancel;  // empty: it cannot be cancelled
    std::shared_ptr<void> memory;  // of its params, in the account; null: little
  };
  std::map<std::string, InProgress> inProgress_;              // its requests, by the text of their id
  std::map<std::string, std::vector<std::string>> warnings_;  // for answers to come, by the text of the request's id
  /// A stream counts for the account as long as it is in the map.
  struct OpenStream {
    std::shared_ptr<Stream> stream;
    std::weak_ptr<SimulationRunner> runner;
    std::shared_ptr<void> place;
  };
  std::map<std::string, OpenStream> streams_;
};

}  // namespace espalier::server

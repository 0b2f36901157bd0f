#pragma once

#include <atomic>
#include <boost/asio.hpp>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "protocol/framing.h"
#include "server/network/admission.h"
#include "server/running/interruption.h"
#include "server/server_core.h"
#include "server/session/connection.h"
#include "server/session/session.h"

namespace espalier::server {

class TurnMeter;

// Only for the files that know the network library: network.cpp, listener.cpp, peer_connection.cpp, http.cpp.

namespace asio = boost::asio;
using boost::system::error_code;
inline constexpr auto kAsTuple = asio::as_tuple(asio::use_awaitable);

/// The data of a connection that are known from accept() on.
struct Accepted {
  std::string peerName;  // for the log
  /// Until then the peer has said hello, after TLS, HTTP and everything else that comes before.
  std::chrono::steady_clock::time_point deadline;
  std::unique_ptr<Admission::Place> place;
};

/// One connected peer over any transport: a reader that hands messages to the session, a writer that empties the
/// outbox. When the outbox is empty, the thread that sends a message writes it, as far as the system takes it at once.
/// Members run on the network thread unless they are Connection's.
class PeerConnection : public Connection, public std::enable_shared_from_this<PeerConnection> {
 public:
  using Batch = std::deque<std::shared_ptr<const std::string>>;

  PeerConnection(asio::any_io_executor executor, ServerCore& core, Accepted accepted);
  ~PeerConnection() override;

  // ---- Connection: any thread ----
  void send(std::shared_ptr<const std::string> message) override;
  void closeWhenSent() override;
  void remind(std::chrono::milliseconds delay) override;
  [[nodiscard]] std::size_t outboxBytes() const override { return outboxBytes_; }
  [[nodiscard]] std::string peerName() const override { return accepted_.peerName; }

  // ---- network thread ----
  [[nodiscard]] std::optional<protocol::Error> admit() override;
  void start(std::shared_ptr<Session> session);
  void closeNow();
  /// Ends the session when its token holds no longer. A peer that does not read this until the next call is closed.
  void checkAccess();
  /// The peer is to be told, then closed.
  [[nodiscard]] bool isBeyondAddressBound() const {
    return accepted_.place != nullptr && accepted_.place->isBeyondAddressBound();
  }
  std::function<void()> onClosed;

 protected:
  /// Does the handshakes before the first message (TLS, the upgrade to a WebSocket). False: the peer is not wanted.
  virtual asio::awaitable<bool> prepare() { co_return true; }
  /// Waits for bytes and hands on what is complete. False: the peer has ended.
  virtual asio::awaitable<bool> receive() = 0;
  virtual asio::awaitable<bool> write(const Batch& messages) = 0;
  /// Writes what the system takes at once of a message; how many bytes, 0 where the transport cannot tell. Any thread,
  /// but neither beside write() nor after closeTransport().
  virtual std::size_t writeNow(const std::string&) { return 0; }
  /// No more is written; the peer may still be sending.
  virtual void shutdownSend() = 0;
  virtual void closeTransport() = 0;

  [[nodiscard]] ServerCore& core() { return *core_; }
  [[nodiscard]] bool isReading() const { return session_ != nullptr && !isClosing_; }
  /// The limits of the peer's messages now; before hello they are low.
  [[nodiscard]] protocol::FrameLimits frameLimits() const;
  void count(std::size_t receivedBytes) {
    core_->metrics.bytesReceived += receivedBytes;
    wasHeard_ = true;
  }
  /// `bytes`: of the message. `isMoreToCome`: the bytes of another one are there.
  void hand(const protocol::MessageReader::Read& read, std::size_t bytes, bool isMoreToCome = false);
  /// This peer has had the network thread for as long as others can wait. The reader then awaits giveWay().
  [[nodiscard]] bool isTurnOver() const { return std::chrono::steady_clock::now() - turnBegin_ > kTurn; }
  /// Other connections take their turns; then this one's next turn begins.
  asio::awaitable<void> giveWay();
  void beginTurn() { turnBegin_ = std::chrono::steady_clock::now(); }
  /// Messages of more bytes are handed on by handOnWorker().
  static constexpr std::size_t kBigMessage = 65'536;
  /// `problem` receives why the framing is lost. Nothing: there is no message.
  using Decode = std::function<std::optional<protocol::MessageReader::Read>(std::optional<protocol::Error>& problem)>;
  /// Decodes a big message and hands it on, on a worker: other peers do not wait. This one's reader does. `decode` uses
  /// nothing that the network thread uses meanwhile, and not session_.
  asio::awaitable<void> handOnWorker(Decode decode);
  /// So many bytes have come from the peer and are not decoded. False: those of all peers are too many. The peer is
  /// told and closed; the caller frees the bytes.
  [[nodiscard]] bool hold(std::size_t bytes);
  void lose(const protocol::Error& error);
  /// Nothing more comes from the peer, which may still read.
  void noteEnd() { hasEnded_ = true; }
  /// Both sides agreed on blocks.
  [[nodiscard]] bool areBlocksAgreed() const { return session_ != nullptr && session_->areBlocksAgreed(); }
  [[nodiscard]] bool isGreeted() const { return session_ != nullptr && session_->isGreeted(); }

 private:
  struct BigMessage;

  /// How long messages of one peer are handled while others wait. With a thousand busy peers each waits a fifth of a
  /// second.
  static constexpr std::chrono::microseconds kTurn{200};

  /// After a message: the peer may have said hello.
  void noteGreeting();
  [[nodiscard]] std::shared_ptr<BigMessage> postToWorker(Decode decode);
  static void decodeAndHandle(BigMessage& message, const TurnMeter& meter);
  void changeOutbox(std::int64_t bytes);
  /// Why the account cannot hold so many bytes that are not decoded, or nothing.
  [[nodiscard]] std::optional<protocol::Error> countHeld(std::size_t bytes);
  void beat();
  void setHeld(bool isHeld);
  void wakeWriter();
  asio::awaitable<void> readAll();
  asio::awaitable<void> writeAll();
  /// After noteEnd().
  asio::awaitable<void> answerRest();
  /// The messages to be written next; empty: none.
  [[nodiscard]] Batch takeOutbox();

  asio::any_io_executor executor_;
  asio::steady_timer wake_;  // cancelled when the outbox has something
  asio::steady_timer handshake_;
  asio::steady_timer heartbeat_;
  asio::steady_timer reminder_;
  bool isReminderSet_ = false;
  ServerCore* core_;
  std::shared_ptr<Session> session_;  // null: closed
  std::atomic<std::size_t> outboxBytes_{0};
  Accepted accepted_;
  std::size_t heldBytes_ = 0;      // hold()
  Account* account_ = nullptr;     // of the peer, once it has said hello
  std::int64_t countedBytes_ = 0;  // of heldBytes_, in the account
  std::chrono::steady_clock::time_point turnBegin_{};
  bool isAdmitted_ = false;
  bool isBeating_ = false;  // heartbeats have begun: the peer was greeted
  bool wasHeard_ = false;   // since the last heartbeat
  bool hasLostAccess_ = false;
  bool hasEnded_ = false;
  bool isHolding_ = false;  // isHeld_
  bool isClosing_ = false;
  std::weak_ptr<Interruption> decoding_;  // of the big message that a worker handles
  bool isClosed_ = false;

  std::mutex mutex_;  // guards what follows; the network thread alone changes the flags
  Batch outbox_;
  bool isReady_ = false;       // the transport works
  bool isWriting_ = false;     // messages taken from the outbox
  bool isHeld_ = false;        // answers to what comes with this message are written together
  bool isWakeComing_ = false;  // the writer is to be woken
  bool isDeaf_ = false;        // takes no more messages
};

}  // namespace espalier::server

#include "server/network/peer_connection.h"

#include <algorithm>
#include <utility>

#include "server/remote/freed_memory.h"
#include "server/running/limit_errors.h"
#include "server/running/turn_meter.h"

namespace espalier::server {
namespace {

constexpr std::chrono::seconds kGrace{1};
// how long a peer that sends no more is still answered, and how often the rest is looked for
constexpr std::chrono::seconds kLastAnswers{2};
constexpr std::chrono::milliseconds kLook{10};
// messages up to so many bytes are written by the thread that sends them
constexpr std::size_t kSmall = 65'536;
// memory that a waiting message takes beside its bytes
constexpr std::size_t kBesideMessage = 128;

/// The memory of a waiting message: a text that was written in pieces may have room for twice its length. The room of a
/// long one does not count, or an answer as large as the bound could close the connection.
std::size_t bytesOf(const std::string& message) {
  return std::min(message.capacity(), message.size() + kSmall) + kBesideMessage;
}

}  // namespace

PeerConnection::PeerConnection(asio::any_io_executor executor, ServerCore& core, Accepted accepted)
    : executor_(std::move(executor)),
      wake_(executor_),
      handshake_(executor_),
      heartbeat_(executor_),
      reminder_(executor_),
      core_(&core),
      accepted_(std::move(accepted)) {
  wake_.expires_at(std::chrono::steady_clock::time_point::max());
}

PeerConnection::~PeerConnection() {
  core_->decodingBytes -= heldBytes_;
  if (account_ != nullptr) {
    account_->add(MemoryKind::Decoding, -countedBytes_);
    account_->add(MemoryKind::Frames, -static_cast<std::int64_t>(outboxBytes_.load()));
  }
}

std::optional<protocol::Error> PeerConnection::admit() {
  if (!accepted_.place->trust()) {
    const std::uint64_t bound = accepted_.place->bounds().sessions;
    return protocol::limitError("sessions", bound + 1, bound, "Close one, or try again later.");
  }
  isAdmitted_ = true;
  account_ = &session_->account();
  account_->add(MemoryKind::Frames, static_cast<std::int64_t>(outboxBytes_.load()));
  ++core_->sessionCount;
  ++core_->metrics.sessions;
  return std::nullopt;
}

void PeerConnection::send(std::shared_ptr<const std::string> message) {
  const std::lock_guard lock(mutex_);
  if (isDeaf_) {
    return;
  }
  if (isReady_ && !isWriting_ && !isHeld_ && outbox_.empty() && message->size() <= kSmall) {
    const std::size_t bytes = writeNow(*message);
    core_->metrics.bytesSent += bytes;
    if (bytes == message->size()) {
      return;
    }
    if (bytes > 0) {
      message = std::make_shared<const std::string>(message->substr(bytes));
    }
  }
  changeOutbox(static_cast<std::int64_t>(bytesOf(*message)));
  outbox_.push_back(std::move(message));
  if (!isWakeComing_) {
    isWakeComing_ = true;
    asio::post(executor_, [self = shared_from_this()] { self->wakeWriter(); });
  }
}

void PeerConnection::closeWhenSent() {
  asio::post(executor_, [self = shared_from_this()] {
    self->isClosing_ = true;
    {
      const std::lock_guard lock(self->mutex_);
      self->isDeaf_ = true;
    }
    self->wake_.cancel();
  });
}

void PeerConnection::remind(std::chrono::milliseconds delay) {
  asio::post(executor_, [self = shared_from_this(), delay] {
    const auto time = std::chrono::steady_clock::now() + delay;
    // one timer, for the earliest time; streams that want a later time ask again
    if (self->isClosed_ || (self->isReminderSet_ && self->reminder_.expiry() <= time)) {
      return;
    }
    self->isReminderSet_ = true;
    self->reminder_.expires_at(time);
    self->reminder_.async_wait([self](const error_code& error) {
      if (error || self->session_ == nullptr) {
        return;
      }
      self->isReminderSet_ = false;
      self->session_->onDrained();
    });
  });
}

void PeerConnection::start(std::shared_ptr<Session> session) {
  session_ = std::move(session);
  asio::co_spawn(
      executor_, [self = shared_from_this()] { return self->readAll(); }, asio::detached);
  asio::co_spawn(
      executor_, [self = shared_from_this()] { return self->writeAll(); }, asio::detached);
  accepted_.place->onEvicted([weak = weak_from_this()] {
    if (const auto self = weak.lock()) {
      self->closeNow();
    }
  });
  handshake_.expires_at(accepted_.deadline);
  handshake_.async_wait([self = shared_from_this()](const error_code& error) {
    if (error || self->session_ == nullptr) {
      return;
    }
    self->session_->onHandshakeTimeout();
    if (!self->isReady_) {
      // the peer cannot be told before the transport works
      self->closeNow();
    }
  });
}

void PeerConnection::beat() {
  const std::uint32_t milliseconds = core_->limits().heartbeatMilliseconds;
  if (milliseconds == 0) {
    return;
  }
  heartbeat_.expires_after(std::chrono::milliseconds(milliseconds));
  heartbeat_.async_wait([self = shared_from_this()](const error_code& error) {
    if (error || self->session_ == nullptr) {
      return;
    }
    if (self->session_->onHeartbeat(std::exchange(self->wasHeard_, false))) {
      self->beat();
      return;
    }
    self->core_->log().info("session with " + self->peerName() + " is closed: it does not answer ping");
    self->closeNow();
  });
}

void PeerConnection::checkAccess() {
  if (session_ == nullptr || !isBeating_) {
    return;
  }
  if (hasLostAccess_) {
    closeNow();
  } else {
    hasLostAccess_ = !session_->checkAccess();
  }
}

void PeerConnection::closeNow() {
  if (isClosed_) {
    return;
  }
  isClosed_ = true;
  // a peer that has left keeps no worker busy
  if (const auto decoding = decoding_.lock()) {
    decoding->interrupt(Interruption::Reason::Cancelled);
  }
  {
    const std::lock_guard lock(mutex_);
    isDeaf_ = true;
    outbox_.clear();
    noteFreed(outboxBytes_);
    closeTransport();
  }
  wake_.cancel();
  handshake_.cancel();
  heartbeat_.cancel();
  reminder_.cancel();
  if (session_ != nullptr) {
    const auto session = std::move(session_);
    session_ = nullptr;
    session->onClosed();
  }
  if (isAdmitted_) {
    --core_->sessionCount;
  }
  accepted_.place.reset();
  if (onClosed) {
    onClosed();
  }
}

protocol::FrameLimits PeerConnection::frameLimits() const {
  const ServerLimits& limits = core_->limits();
  const std::uint64_t lineBytes = isGreeted() ? limits.lineBytes : std::min(limits.lineBytes, limits.helloBytes);
  return {static_cast<std::size_t>(lineBytes), static_cast<std::size_t>(limits.blockBytes)};
}

void PeerConnection::setHeld(bool isHeld) {
  if (isHeld != isHolding_) {
    isHolding_ = isHeld;
    const std::lock_guard lock(mutex_);
    isHeld_ = isHeld;
  }
}

void PeerConnection::hand(const protocol::MessageReader::Read& read, std::size_t bytes, bool isMoreToCome) {
  setHeld(isMoreToCome);
  session_->onRead(read, bytes);
  noteGreeting();
}

void PeerConnection::noteGreeting() {
  if (isGreeted() && !isBeating_) {
    isBeating_ = true;
    handshake_.cancel();
    beat();
  }
}

/// A message that a worker handles. Shared with the worker, which may outlive the frame of the coroutine.
struct PeerConnection::BigMessage {
  std::shared_ptr<PeerConnection> self;
  std::shared_ptr<Session> session;
  Decode decode;
  asio::steady_timer done;
  std::shared_ptr<Interruption> interruption = std::make_shared<Interruption>();
  bool isDone = false;  // network thread
};

void PeerConnection::decodeAndHandle(BigMessage& message, const TurnMeter& meter) {
  std::optional<protocol::Error> problem;
  std::optional<protocol::MessageId> request;
  if (const auto read = message.decode(problem)) {
    message.session->onRead(*read);
    if (*read && (*read)->kind == protocol::Message::Kind::Request) {
      request = (*read)->id;
    }
  } else if (problem) {
    message.session->onLost(*problem);
  }
  // the memory of its params, when they wait
  if (request && meter.held() > 0) {
    message.session->holdForRequest(*request, static_cast<std::size_t>(meter.held()));
  }
}

std::shared_ptr<PeerConnection::BigMessage> PeerConnection::postToWorker(Decode decode) {
  const auto message = std::make_shared<BigMessage>(
      BigMessage{shared_from_this(), session_, std::move(decode), asio::steady_timer(executor_)});
  message->done.expires_at(std::chrono::steady_clock::time_point::max());
  decoding_ = message->interruption;
  const std::uint32_t callSeconds = core_->limits().callSeconds;
  auto run = [message = message, callSeconds]() mutable {
    TurnMeter meter(message->session->account(), MemoryKind::Decoding, TurnMeter::WhenStopped::GetsNoMemory);
    std::optional<std::string> failure;
    {
      const core::WorkMeter::Scope scope(&meter);
      const Interruption::Scope stopping(*message->interruption, [&meter] { meter.stop(); });
      try {
        decodeAndHandle(*message, meter);
      } catch (const std::exception& exception) {
        failure = exception.what();
      }
    }
    if (failure) {
      message->session->onLost(
          message->interruption->reason() != Interruption::Reason::None
              ? callSecondsError(callSeconds, "The message was not read, and the connection is closed.", {})
          : meter.isRefused() ? message->session->account().memoryError()
                              : protocol::Error{protocol::ErrorCode::Internal,
                                                "This message could not be handled: " + *failure +
                                                    ". Send smaller messages; the connection is closed.",
                                                {}});
    }
    // the network thread drops the connection, if it is the last to hold it
    const auto executor = message->self->executor_;
    asio::post(executor, [message = std::move(message)] {
      message->isDone = true;
      message->done.cancel();
    });
  };
  core_->pool().post(
      {.run = std::move(run),
       .lane = Lane::Decode,
       .owner = session_->id(),
       .limit = std::chrono::seconds(callSeconds),
       .onLimit = [stopped = message->interruption] { stopped->interrupt(Interruption::Reason::CallSeconds); }});
  return message;
}

asio::awaitable<void> PeerConnection::handOnWorker(Decode decode) {
  setHeld(false);
  const auto message = postToWorker(std::move(decode));
  while (!message->isDone) {
    co_await message->done.async_wait(kAsTuple);
  }
  noteGreeting();
  // work that the message began may not have existed yet when the connection was closed
  if (isClosed_) {
    message->session->onClosed();
  }
}

asio::awaitable<void> PeerConnection::giveWay() {
  co_await asio::post(executor_, asio::use_awaitable);
  beginTurn();
}

void PeerConnection::changeOutbox(std::int64_t bytes) {
  outboxBytes_ += static_cast<std::size_t>(bytes);
  if (account_ != nullptr) {
    account_->add(MemoryKind::Frames, bytes);
  }
}

std::optional<protocol::Error> PeerConnection::countHeld(std::size_t bytes) {
  if (account_ == nullptr) {
    return std::nullopt;
  }
  const std::int64_t more = static_cast<std::int64_t>(bytes) - std::exchange(countedBytes_, 0);
  // a short line costs others nothing
  if (more > 0 && bytes > kBigMessage && !account_->take(MemoryKind::Decoding, static_cast<std::uint64_t>(more))) {
    account_->add(MemoryKind::Decoding, more - static_cast<std::int64_t>(bytes));
    return account_->memoryError();
  }
  if (more <= 0 || bytes <= kBigMessage) {
    account_->add(MemoryKind::Decoding, more);
  }
  countedBytes_ = static_cast<std::int64_t>(bytes);
  return std::nullopt;
}

bool PeerConnection::hold(std::size_t bytes) {
  const std::uint64_t all = core_->decodingBytes += bytes - heldBytes_;
  heldBytes_ = bytes;
  const std::uint64_t bound = core_->limits().decodingBytes;
  std::optional<protocol::Error> problem = countHeld(bytes);
  if (!problem && bytes > kBigMessage && all > bound) {
    problem = protocol::limitError("decodingBytes", all, bound, "Try again later; the connection is closed.");
  }
  if (!problem) {
    return true;
  }
  core_->decodingBytes -= std::exchange(heldBytes_, 0);
  (void)countHeld(0);
  lose(*problem);
  return false;
}

void PeerConnection::lose(const protocol::Error& error) {
  if (isReading()) {
    session_->onLost(error);
    isClosing_ = true;
  }
}

void PeerConnection::wakeWriter() {
  {
    const std::lock_guard lock(mutex_);
    isWakeComing_ = false;
  }
  // one answer may be as large as the bound while another is being sent
  const std::uint64_t bound = core_->limits().outboxBytes;
  if (outboxBytes_ > 2 * bound && !isClosing_) {
    core_->log().warn(
        "session with " + peerName() +
        " is closed: it does not read, and its outbox grew beyond twice outboxBytes=" + std::to_string(bound));
    closeNow();
    return;
  }
  wake_.cancel();
}

asio::awaitable<void> PeerConnection::readAll() {
  const bool isWanted = co_await prepare();
  {
    const std::lock_guard lock(mutex_);
    isReady_ = isWanted;
  }
  wake_.cancel();
  bool goesOn = isWanted;
  while (goesOn && !isClosed_) {
    // not in the condition: g++ 12 makes wrong code of that
    goesOn = co_await receive();
  }
  if (hasEnded_ && !isClosed_) {
    co_await answerRest();
  }
  closeNow();
}

asio::awaitable<void> PeerConnection::answerRest() {
  session_->onPeerEnded();
  const auto end = std::chrono::steady_clock::now() + kLastAnswers;
  asio::steady_timer look(executor_);
  while (!isClosed_ && (session_->isAnswering() || outboxBytes_ > 0) && std::chrono::steady_clock::now() < end) {
    look.expires_after(kLook);
    co_await look.async_wait(kAsTuple);
  }
}

PeerConnection::Batch PeerConnection::takeOutbox() {
  const std::lock_guard lock(mutex_);
  isWriting_ = isReady_ && !outbox_.empty();
  return isWriting_ ? std::exchange(outbox_, {}) : Batch();
}

asio::awaitable<void> PeerConnection::writeAll() {
  while (!isClosed_) {
    // everything queued, in one system call where possible
    const Batch sending = takeOutbox();
    if (sending.empty()) {
      if (isClosing_) {
        break;
      }
      co_await wake_.async_wait(kAsTuple);
      wake_.expires_at(std::chrono::steady_clock::time_point::max());
      continue;
    }
    std::size_t bytes = 0;
    std::size_t memory = 0;
    for (const auto& message : sending) {
      bytes += message->size();
      memory += bytesOf(*message);
    }
    const bool isSent = co_await write(sending);
    changeOutbox(-static_cast<std::int64_t>(memory));
    // the messages themselves are freed before this thread does anything else
    noteFreed(memory);
    if (!isSent) {
      break;
    }
    core_->metrics.bytesSent += bytes;
    if (session_ != nullptr) {
      session_->onDrained();
    }
  }
  // the peer may still be sending: let it read the last message before the connection is reset
  if (!isClosed_ && isClosing_) {
    shutdownSend();
    // the reader closes at once when the peer does, which also ends this wait
    wake_.expires_after(kGrace);
    co_await wake_.async_wait(kAsTuple);
  }
  closeNow();
}

}  // namespace espalier::server

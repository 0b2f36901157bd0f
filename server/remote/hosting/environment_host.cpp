#include "server/remote/hosting/environment_host.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio.hpp>
#include <exception>
#include <memory>
#include <new>
#include <string_view>
#include <thread>

#include "protocol/framing.h"
#include "server/remote/control_group.h"
#include "server/remote/freed_memory.h"
#include "server/remote/hosting/environment_dialogue.h"
#include "server/remote/hosting/host_connections.h"
#include "server/remote/hosting/host_memory.h"

namespace espalier::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr protocol::FrameLimits kLimits;

constexpr std::size_t kReadBytes = 262'144;

// connections that have sent no message yet
constexpr std::size_t kMostSilent = 128;
// at most: each has memory for what it reads
constexpr std::size_t kMostConnections = 4096;
// for files and programs of the environment
constexpr std::size_t kReservedDescriptors = 64;
// refusals that wait for their peers to read them
constexpr int kMostRefusals = 16;

using Socket = HostConnections::Socket;

/// Never more connections than there are descriptors for.
std::size_t mostConnections(std::size_t asked) {
  if (asked > 0) {
    return asked;
  }
  ::rlimit bound{};
  const std::size_t descriptors =
      ::getrlimit(RLIMIT_NOFILE, &bound) == 0 ? static_cast<std::size_t>(bound.rlim_cur) : 1024;
  return std::clamp<std::size_t>(descriptors - std::min(descriptors / 2, kReservedDescriptors), 8, kMostConnections);
}

/// The part of a host that all its connections share. It outlives them.
struct Host {
  const ProcessFactory& factory;
  std::chrono::milliseconds firstMessage;
  std::uint64_t mostHeldBytes;
  HostConnections connections;
  HostMemory memory;
  std::atomic<std::uint64_t> heldBytes{0};  // of messages that have come in part
  std::atomic<int> refusals{0};             // under way
};

/// The bytes of one connection in Host::heldBytes.
class HeldBytes {
 public:
  explicit HeldBytes(Host& host) : host_(&host) {}
  ~HeldBytes() { host_->heldBytes -= bytes_; }
  HeldBytes(const HeldBytes&) = delete;
  HeldBytes& operator=(const HeldBytes&) = delete;

  /// An error when all connections together have too many. Those of a short message cost the others nothing.
  [[nodiscard]] std::optional<protocol::Error> set(std::size_t bytes) {
    constexpr std::size_t kShort = 65'536;
    const std::uint64_t all = host_->heldBytes += bytes - bytes_;
    bytes_ = bytes;
    return bytes <= kShort || all <= host_->mostHeldBytes
               ? std::nullopt
               : std::optional(protocol::limitError("decodingBytes", all, host_->mostHeldBytes,
                                                    "Try again later; the connection is closed."));
  }

 private:
  Host* host_;
  std::uint64_t bytes_ = 0;
};

/// The messages of one connection and their answers. All its memory counts for the connection.
class ServedMessages {
 public:
  enum class Next : std::uint8_t { None, Unanswered, Answered };

  explicit ServedMessages(Host& host) : memory_(host.memory) {
    const core::WorkMeter::Scope scope(&memory_);
    dialogue_.emplace(host.factory, kLimits);
    reader_.emplace(kLimits);
  }
  ~ServedMessages() {
    const std::size_t held = memory_.held();
    {
      const core::WorkMeter::Scope scope(&memory_);
      reply_ = {};
      dialogue_.reset();
      reader_.reset();
    }
    noteFreed(held);
  }
  ServedMessages(const ServedMessages&) = delete;
  ServedMessages& operator=(const ServedMessages&) = delete;

  void feed(std::string_view bytes) {
    const core::WorkMeter::Scope scope(&memory_);
    reader_->feed(bytes);
    before_ = reader_->heldBytes();
  }
  /// Answers the next message that is there, after onMessage() if it is one and no rubbish. std::bad_alloc: it takes
  /// more memory than there is.
  Next next(const std::function<void()>& onMessage) {
    const core::WorkMeter::Scope scope(&memory_);
    reply_ = {};
    memory_.setReading(true);
    const auto read = reader_->next();
    memory_.setReading(false);
    if (!read) {
      return Next::None;
    }
    const bool isMessage = read->has_value();
    if (isMessage) {
      onMessage();
    }
    auto reply = isMessage && memory_.isFull() && takesMemory((*read)->method)
                     ? std::optional(protocol::encodeError((*read)->id, memoryError()))
                     : dialogue_->answer(*read);
    if (dialogue_->areBlocksAgreed()) {
      reader_->allowBlocks();
    }
    if (!reply) {
      return Next::Unanswered;
    }
    reply_ = std::move(*reply);
    return Next::Answered;
  }
  [[nodiscard]] const std::string& reply() const { return reply_; }
  [[nodiscard]] bool hasSimulations() const { return dialogue_->hasSimulations(); }
  /// Gives back the memory of messages that are gone.
  void rest() {
    const core::WorkMeter::Scope scope(&memory_);
    reader_->rest();
    noteFreed(before_ - std::min(before_, reader_->heldBytes()));
  }
  [[nodiscard]] std::size_t heldBytes() const { return reader_->heldBytes(); }
  [[nodiscard]] const std::optional<protocol::Error>& lost() const { return reader_->lost(); }
  [[nodiscard]] protocol::Error memoryError() const {
    const HostMemory& host = memory_.host();
    const auto held = static_cast<std::uint64_t>(std::max<std::int64_t>(host.held, 0));
    return protocol::limitError("memoryBytes", std::max(held, host.most + 1), host.most,
                                "Close simulations, or send smaller messages.");
  }

 private:
  static bool takesMemory(std::string_view method) {
    return method == "environment.open" || method == "environment.step" || method == "environment.restore";
  }

  ConnectionMemory memory_;  // of the members below
  std::optional<EnvironmentDialogue> dialogue_;
  std::optional<protocol::MessageReader> reader_;
  std::string reply_;
  std::size_t before_ = 0;  // bytes that the reader had
};

/// Closes the connection when it is still silent after a time. The caller keeps the timer.
void closeWhenSilent(asio::steady_timer& timer, Host& host, const Socket& socket) {
  timer.expires_after(host.firstMessage);
  timer.async_wait([&host, weak = std::weak_ptr(socket)](const boost::system::error_code& error) {
    const Socket waiting = error ? nullptr : weak.lock();
    if (waiting != nullptr && host.connections.leaveSilent(waiting)) {
      boost::system::error_code ignored;
      waiting->close(ignored);
    }
  });
}

/// One connection: lines are answered in their order, one at a time.
asio::awaitable<void> serveConnection(Socket shared, Host& host) {
  tcp::socket& socket = *shared;
  boost::system::error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  // a machine that has vanished is noticed
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  asio::steady_timer timer(socket.get_executor());
  closeWhenSilent(timer, host, shared);
  ServedMessages messages(host);
  HeldBytes held(host);
  auto bytes = std::make_unique_for_overwrite<std::array<char, kReadBytes>>();
  // before the answer is computed: what computes gives way to nobody
  const std::function<void()> onMessage = [&] {
    if (host.connections.begin(shared)) {
      timer.cancel();
    }
  };
  const auto token = asio::as_tuple(asio::use_awaitable);
  while (true) {
    const auto [error, count] = co_await socket.async_read_some(asio::buffer(*bytes), token);
    if (error) {
      co_return;
    }
    messages.feed({bytes->data(), count});
    std::optional<protocol::Error> problem;
    while (!problem) {
      ServedMessages::Next next = ServedMessages::Next::None;
      try {
        next = messages.next(onMessage);
      } catch (const std::bad_alloc&) {
        problem = messages.memoryError();
      }
      if (next == ServedMessages::Next::None) {
        break;
      }
      if (next == ServedMessages::Next::Answered) {
        const auto [writeError, written] = co_await asio::async_write(socket, asio::buffer(messages.reply()), token);
        if (writeError) {
          co_return;
        }
      }
    }
    messages.rest();
    host.connections.end(shared, messages.hasSimulations());
    if (auto tooMany = held.set(messages.heldBytes())) {
      problem = std::move(tooMany);
    }
    if (messages.lost()) {
      problem = messages.lost();
    }
    if (problem) {
      const std::string reply = protocol::encodeError({}, *problem);
      co_await asio::async_write(socket, asio::buffer(reply), token);
      co_return;
    }
  }
}

/// Says why there is no place, and waits a moment for the peer to read that.
asio::awaitable<void> refuse(Socket socket, Host& host) {
  const auto token = asio::as_tuple(asio::use_awaitable);
  asio::steady_timer timer(socket->get_executor(), std::chrono::seconds(1));
  timer.async_wait([socket](const boost::system::error_code&) {
    boost::system::error_code ignored;
    socket->close(ignored);
  });
  const std::size_t most = host.connections.most();
  const std::string reply = protocol::encodeError(
      {}, protocol::limitError("connections", most + 1, most,
                               "All of them have simulations. Close one, or start the environment once more."));
  const auto [error, written] = co_await asio::async_write(*socket, asio::buffer(reply), token);
  boost::system::error_code problem = error;
  socket->shutdown(tcp::socket::shutdown_send, problem);
  std::array<char, 1024> rest{};
  while (!problem) {
    const auto [readError, count] = co_await socket->async_read_some(asio::buffer(rest), token);
    problem = readError;
  }
  timer.cancel();
}

/// Serves a new connection, or refuses it.
void admit(const Socket& socket, Host& host) {
  if (host.connections.enter(socket)) {
    asio::co_spawn(socket->get_executor(), serveConnection(socket, host),
                   [&host, socket](const std::exception_ptr&) { host.connections.leave(socket); });
  } else if (++host.refusals <= kMostRefusals) {
    asio::co_spawn(socket->get_executor(), refuse(socket, host),
                   [&host](const std::exception_ptr&) { --host.refusals; });
  } else {
    --host.refusals;
  }
}

asio::awaitable<void> acceptConnections(tcp::acceptor& acceptor, Host& host) {
  while (true) {
    // each connection computes on a strand of its own, so that one does not wait for another
    auto [error, socket] =
        co_await acceptor.async_accept(asio::make_strand(acceptor.get_executor()), asio::as_tuple(asio::use_awaitable));
    if (error == asio::error::operation_aborted || !acceptor.is_open()) {
      co_return;
    }
    if (error) {
      // a silent or idle connection gives back its descriptor
      const bool isMade = error == asio::error::no_descriptors && host.connections.closeOne();
      asio::steady_timer pause(acceptor.get_executor(), std::chrono::milliseconds(isMade ? 1 : 100));
      co_await pause.async_wait(asio::as_tuple(asio::use_awaitable));
      continue;
    }
    admit(std::make_shared<tcp::socket>(std::move(socket)), host);
  }
}

/// Gives back freed memory, also when nobody says anything.
asio::awaitable<void> trimFromTimeToTime(asio::io_context& context) {
  asio::steady_timer timer(context);
  while (true) {
    timer.expires_after(std::chrono::seconds(1));
    co_await timer.async_wait(asio::as_tuple(asio::use_awaitable));
    trimHeap();
  }
}

}  // namespace

std::optional<std::string> hostEnvironment(const HostAddress& address, const ProcessFactory& factory,
                                           const std::function<void(std::uint16_t)>& onListening) {
  const auto& [host, port, isInsecureAllowed, firstMessage, heldBytes, connections, memoryBytes] = address;
  const unsigned threadCount = std::max(2U, processorCount());
  boundHeaps(threadCount);
  Host shared{factory,
              firstMessage,
              heldBytes,
              {mostConnections(connections), kMostSilent},
              {memoryBytes > 0 ? memoryBytes : usableMemoryBytes()}};
  asio::io_context context(static_cast<int>(threadCount));
  tcp::acceptor acceptor(context);
  boost::system::error_code error;
  tcp::resolver resolver(context);
  const auto found = resolver.resolve(host, std::to_string(port), tcp::resolver::passive, error);
  if (error || found.empty()) {
    return "the address '" + host + "' is unknown; use 127.0.0.1 or an address of this machine.";
  }
  const tcp::endpoint endpoint = found.begin()->endpoint();
  if (!endpoint.address().is_loopback() && !isInsecureAllowed) {
    return "'" + host +
           "' can be reached from other machines, and an environment does not ask for a token: add --insecure if that "
           "is "
           "acceptable, or listen on 127.0.0.1.";
  }
  acceptor.open(endpoint.protocol(), error);
  if (!error) {
    acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    acceptor.bind(endpoint, error);
  }
  if (!error) {
    acceptor.listen(asio::socket_base::max_listen_connections, error);
  }
  if (error) {
    return "cannot listen on " + host + ":" + std::to_string(port) + ": " + error.message() +
           ". Choose another port, or 0 for a free one.";
  }

  asio::signal_set signals(context, SIGINT, SIGTERM);
  signals.async_wait([&](const boost::system::error_code& problem, int) {
    if (!problem) {
      context.stop();
    }
  });
  asio::co_spawn(context, acceptConnections(acceptor, shared), asio::detached);
  asio::co_spawn(context, trimFromTimeToTime(context), asio::detached);
  onListening(acceptor.local_endpoint().port());
  std::vector<std::jthread> threads;
  for (unsigned i = 1; i < threadCount; ++i) {
    threads.emplace_back([&context] { context.run(); });
  }
  context.run();
  return std::nullopt;
}

std::optional<std::string> hostEnvironmentOnStdio(const ProcessFactory& factory) {
  EnvironmentDialogue dialogue(factory, kLimits);
  protocol::MessageReader reader(kLimits);
  const auto bytes = std::make_unique_for_overwrite<std::array<char, kReadBytes>>();
  const auto writeAll = [](std::string_view text) {
    while (!text.empty()) {
      const ssize_t count = ::write(STDOUT_FILENO, text.data(), text.size());
      if (count < 0 && errno != EINTR) {
        return false;
      }
      text.remove_prefix(count > 0 ? static_cast<std::size_t>(count) : 0);
    }
    return true;
  };
  while (true) {
    const ssize_t count = ::read(STDIN_FILENO, bytes->data(), bytes->size());
    if (count < 0 && errno == EINTR) {
      continue;
    }
    if (count <= 0) {
      return std::nullopt;
    }
    reader.feed({bytes->data(), static_cast<std::size_t>(count)});
    while (const auto read = reader.next()) {
      if (const auto reply = dialogue.answer(*read); reply && !writeAll(*reply)) {
        return std::nullopt;
      }
      if (dialogue.areBlocksAgreed()) {
        reader.allowBlocks();
      }
    }
    if (reader.lost()) {
      (void)writeAll(protocol::encodeError({}, *reader.lost()));
      return reader.lost()->message;
    }
    reader.rest();
  }
}

}  // namespace espalier::server

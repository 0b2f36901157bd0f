#include "server/remote/hosting/environment_host.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio.hpp>
#include <exception>
#include <list>
#include <memory>
#include <mutex>
#include <thread>

#include "protocol/framing.h"
#include "server/remote/control_group.h"
#include "server/remote/freed_memory.h"
#include "server/remote/hosting/environment_dialogue.h"

namespace espalier::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr protocol::FrameLimits kLimits;

constexpr std::size_t kReadBytes = 262'144;

// connections that have sent no message yet
constexpr std::size_t kMostSilent = 128;

using Socket = std::shared_ptr<tcp::socket>;

/// Connections that have sent no message yet. The one that has waited longest gives way to others, so that they never
/// lock out a server. Thread-safe.
class SilentConnections {
 public:
  void enter(const Socket& socket) {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= kMostSilent) {
      closeFirst();
    }
    waiting_.push_back(socket);
  }
  /// False: it was not there any more.
  bool leave(const Socket& socket) {
    const std::lock_guard lock(mutex_);
    return waiting_.remove(socket) > 0;
  }
  /// Closes the connection that has waited longest. False: none waits.
  bool closeOne() {
    const std::lock_guard lock(mutex_);
    const bool isThere = !waiting_.empty();
    if (isThere) {
      closeFirst();
    }
    return isThere;
  }

 private:
  void closeFirst() {
    // on its own strand
    asio::post(waiting_.front()->get_executor(), [socket = waiting_.front()] {
      boost::system::error_code ignored;
      socket->close(ignored);
    });
    waiting_.pop_front();
  }

  std::mutex mutex_;
  std::list<Socket> waiting_;  // the longest first
};

/// The part of a host that all its connections share. It outlives them.
struct Host {
  const ProcessFactory& factory;
  std::chrono::milliseconds firstMessage;
  std::uint64_t mostHeldBytes;
  SilentConnections silent{};
  std::atomic<std::uint64_t> heldBytes{0};  // of messages that have come in part
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

/// Closes the connection when it is still silent after a time. The caller keeps the timer.
void closeWhenSilent(asio::steady_timer& timer, Host& host, const Socket& socket) {
  timer.expires_after(host.firstMessage);
  timer.async_wait([&host, weak = std::weak_ptr(socket)](const boost::system::error_code& error) {
    const Socket waiting = error ? nullptr : weak.lock();
    if (waiting != nullptr && host.silent.leave(waiting)) {
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
  asio::steady_timer timer(socket.get_executor());
  closeWhenSilent(timer, host, shared);
  EnvironmentDialogue dialogue(host.factory, kLimits);
  protocol::MessageReader reader(kLimits);
  HeldBytes held(host);
  auto bytes = std::make_unique_for_overwrite<std::array<char, kReadBytes>>();
  const auto token = asio::as_tuple(asio::use_awaitable);
  while (true) {
    const auto [error, count] = co_await socket.async_read_some(asio::buffer(*bytes), token);
    if (error) {
      co_return;
    }
    reader.feed({bytes->data(), count});
    const std::size_t before = reader.heldBytes();
    while (const auto read = reader.next()) {
      if (read->has_value() && host.silent.leave(shared)) {
        timer.cancel();
      }
      if (const auto reply = dialogue.answer(*read)) {
        const auto [writeError, written] = co_await asio::async_write(socket, asio::buffer(*reply), token);
        if (writeError) {
          co_return;
        }
      }
      if (dialogue.areBlocksAgreed()) {
        reader.allowBlocks();
      }
    }
    reader.rest();
    noteFreed(before - std::min(before, reader.heldBytes()));
    trimHeap();
    std::optional<protocol::Error> problem = held.set(reader.heldBytes());
    if (reader.lost()) {
      problem = reader.lost();
    }
    if (problem) {
      const std::string reply = protocol::encodeError({}, *problem);
      co_await asio::async_write(socket, asio::buffer(reply), token);
      co_return;
    }
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
      // a silent connection gives back its descriptor
      const bool isMade = error == asio::error::no_descriptors && host.silent.closeOne();
      asio::steady_timer pause(acceptor.get_executor(), std::chrono::milliseconds(isMade ? 1 : 100));
      co_await pause.async_wait(asio::as_tuple(asio::use_awaitable));
      continue;
    }
    const auto shared = std::make_shared<tcp::socket>(std::move(socket));
    host.silent.enter(shared);
    asio::co_spawn(shared->get_executor(), serveConnection(shared, host),
                   [&host, shared](const std::exception_ptr&) { host.silent.leave(shared); });
  }
}

}  // namespace

std::optional<std::string> hostEnvironment(const HostAddress& address, const ProcessFactory& factory,
                                           const std::function<void(std::uint16_t)>& onListening) {
  const auto& [host, port, isInsecureAllowed, firstMessage, heldBytes] = address;
  const unsigned threadCount = std::max(2U, processorCount());
  boundHeaps(threadCount);
  Host shared{factory, firstMessage, heldBytes};
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

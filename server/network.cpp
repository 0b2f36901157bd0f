#include "server/network.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio.hpp>
#include <csignal>
#include <deque>
#include <set>
#include <vector>

#include "protocol/envelope.h"
#include "protocol/framing.h"
#include "protocol/json_writer.h"
#include "server/connection.h"
#include "server/server_core.h"
#include "server/session.h"

namespace espalier::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr auto kToken = asio::as_tuple(asio::use_awaitable);
constexpr std::size_t kReadBytes = 262'144;
constexpr std::chrono::seconds kGrace{1};

/// One TCP connection: a reader that hands lines to the session, a writer that empties the outbox. Members run on the
/// network thread unless they are Connection's.
class TcpConnection final : public Connection, public std::enable_shared_from_this<TcpConnection> {
 public:
  TcpConnection(tcp::socket socket, ServerCore& core)
      : socket_(std::move(socket)),
        executor_(socket_.get_executor()),
        wake_(executor_),
        handshake_(executor_),
        core_(&core) {
    error_code error;
    const auto endpoint = socket_.remote_endpoint(error);
    peerName_ = error ? "unknown" : endpoint.address().to_string() + ":" + std::to_string(endpoint.port());
    isLocal_ = !error && endpoint.address().is_loopback();
    socket_.set_option(tcp::no_delay(true), error);
    socket_.set_option(asio::socket_base::keep_alive(true), error);
    wake_.expires_at(std::chrono::steady_clock::time_point::max());
  }

  // ---- Connection: any thread ----

  void send(std::shared_ptr<const std::string> line) override {
    outboxBytes_ += line->size();
    asio::post(executor_,
               [self = shared_from_this(), line = std::move(line)]() mutable { self->enqueue(std::move(line)); });
  }
  void closeWhenSent() override {
    asio::post(executor_, [self = shared_from_this()] {
      self->isClosing_ = true;
      self->wake_.cancel();
    });
  }
  [[nodiscard]] std::size_t outboxBytes() const override { return outboxBytes_; }
  [[nodiscard]] bool isLocal() const override { return isLocal_; }
  [[nodiscard]] std::string peerName() const override { return peerName_; }

  // ---- network thread ----

  void start(std::shared_ptr<Session> session) {
    session_ = std::move(session);
    asio::co_spawn(
        executor_, [self = shared_from_this()] { return self->read(); }, asio::detached);
    asio::co_spawn(
        executor_, [self = shared_from_this()] { return self->write(); }, asio::detached);
    handshake_.expires_after(std::chrono::milliseconds(core_->options().limits.handshakeMilliseconds));
    handshake_.async_wait([self = shared_from_this()](const error_code& error) {
      if (!error && self->session_ != nullptr) {
        self->session_->onHandshakeTimeout();
      }
    });
  }

  void closeNow() {
    if (isClosed_) {
      return;
    }
    isClosed_ = true;
    error_code ignored;
    socket_.shutdown(tcp::socket::shutdown_both, ignored);
    socket_.close(ignored);
    wake_.cancel();
    handshake_.cancel();
    outbox_.clear();
    if (session_ != nullptr) {
      const auto session = std::move(session_);
      session_ = nullptr;
      session->onClosed();
    }
    if (onClosed) {
      onClosed();
    }
  }

  std::function<void()> onClosed;

 private:
  void enqueue(std::shared_ptr<const std::string> line) {
    if (isClosed_ || isClosing_) {
      outboxBytes_ -= line->size();
      // a refusal itself is queued before closing begins
      return;
    }
    outbox_.push_back(std::move(line));
    const std::uint64_t bound = core_->options().limits.outboxBytes;
    // one answer may be as large as the bound while another is being sent
    if (outboxBytes_ > 2 * bound) {
      core_->log().warn("session with " + peerName_ +
                        " is closed: it does not read, and its outbox grew beyond twice " +
                        "outboxBytes=" + std::to_string(bound));
      closeNow();
      return;
    }
    wake_.cancel();
  }

  asio::awaitable<void> read() {
    const ServerLimits& limits = core_->options().limits;
    protocol::MessageReader reader(
        {static_cast<std::size_t>(limits.lineBytes), static_cast<std::size_t>(limits.blockBytes)});
    const auto bytes = std::make_unique<std::array<char, kReadBytes>>();
    while (!isClosed_) {
      const auto [error, count] = co_await socket_.async_read_some(asio::buffer(*bytes), kToken);
      if (error) {
        break;
      }
      if (isClosing_) {
        continue;
      }
      reader.feed({bytes->data(), count});
      while (session_ != nullptr && !isClosing_) {
        const auto read = reader.next();
        if (!read) {
          break;
        }
        session_->onRead(*read);
        if (session_ != nullptr && session_->isGreeted()) {
          handshake_.cancel();
          if (session_->terms().takesBlocks) {
            reader.allowBlocks();
          }
        }
      }
      if (reader.lost() && session_ != nullptr && !isClosing_) {
        session_->onLost(*reader.lost());
      }
    }
    closeNow();
  }

  asio::awaitable<void> write() {
    std::vector<asio::const_buffer> buffers;
    while (!isClosed_) {
      if (outbox_.empty()) {
        if (isClosing_) {
          break;
        }
        co_await wake_.async_wait(kToken);
        wake_.expires_at(std::chrono::steady_clock::time_point::max());
        continue;
      }
      // everything queued, in one system call where possible
      const auto sending = std::move(outbox_);
      outbox_.clear();
      buffers.clear();
      std::size_t bytes = 0;
      for (const auto& line : sending) {
        buffers.push_back(asio::buffer(*line));
        bytes += line->size();
      }
      const auto [error, count] = co_await asio::async_write(socket_, buffers, kToken);
      outboxBytes_ -= bytes;
      if (error) {
        break;
      }
      if (session_ != nullptr) {
        session_->onDrained();
      }
    }
    // the peer may still be sending: let it read the last line before the connection is reset
    if (!isClosed_ && isClosing_) {
      error_code ignored;
      socket_.shutdown(tcp::socket::shutdown_send, ignored);
      // the reader closes at once when the peer does, which also ends this wait
      wake_.expires_after(kGrace);
      co_await wake_.async_wait(kToken);
    }
    closeNow();
  }

  tcp::socket socket_;
  asio::any_io_executor executor_;
  asio::steady_timer wake_;  // cancelled when the outbox has something
  asio::steady_timer handshake_;
  ServerCore* core_;
  std::shared_ptr<Session> session_;  // null: closed
  std::deque<std::shared_ptr<const std::string>> outbox_;
  std::atomic<std::size_t> outboxBytes_{0};
  std::string peerName_;
  bool isLocal_ = false;
  bool isClosing_ = false;
  bool isClosed_ = false;
};

}  // namespace

class Network::Implementation {
 public:
  explicit Implementation(ServerCore& core)
      : core_(&core), context_(1), acceptor_(context_), signals_(context_), patience_(context_) {}

  std::optional<std::string> listen(const std::string& host, std::uint16_t port) {
    error_code error;
    tcp::resolver resolver(context_);
    const auto found = resolver.resolve(host, std::to_string(port), tcp::resolver::passive, error);
    if (error || found.empty()) {
      return "cannot listen on '" + host + "': the address is unknown. Use 127.0.0.1 or an address of this machine.";
    }
    const tcp::endpoint endpoint = found.begin()->endpoint();
    acceptor_.open(endpoint.protocol(), error);
    if (!error) {
      acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
      acceptor_.bind(endpoint, error);
    }
    if (!error) {
      acceptor_.listen(asio::socket_base::max_listen_connections, error);
    }
    if (error == asio::error::address_in_use) {
      return "cannot listen on " + host + ":" + std::to_string(port) +
             ": the port is in use. Choose another with --listen, or port 0 for a free one.";
    }
    if (error) {
      return "cannot listen on " + host + ":" + std::to_string(port) + ": " + error.message() +
             ". Choose another address with --listen.";
    }
    port_ = acceptor_.local_endpoint().port();
    return std::nullopt;
  }

  [[nodiscard]] std::uint16_t port() const { return port_; }

  void run(bool handleSignals, std::function<void()> onStop) {
    onStop_ = std::move(onStop);
    if (handleSignals) {
      signals_.add(SIGINT);
      signals_.add(SIGTERM);
      waitForSignal();
    }
    asio::co_spawn(context_, accept(), asio::detached);
    context_.run();
  }

  void stopAccepting() {
    asio::post(context_, [this] {
      error_code ignored;
      acceptor_.close(ignored);
    });
  }

  void announceShutdown() {
    asio::post(context_, [this] {
      protocol::JsonWriter params;
      params.beginObject().key("message").text("The server is shutting down. Running steps are finished and saved.");
      params.endObject();
      const auto line =
          std::make_shared<const std::string>(protocol::encodeNotification("server.shutdown", params.take()));
      for (const auto& connection : connections_) {
        connection->send(line);
      }
    });
  }

  void close(std::chrono::milliseconds patience) {
    asio::post(context_, [this, patience] {
      isClosing_ = true;
      for (const auto& connection : connections_) {
        connection->closeWhenSent();
      }
      patience_.expires_after(patience);
      patience_.async_wait([this](const error_code& error) {
        if (!error) {
          for (const auto& connection : std::set(connections_)) {
            connection->closeNow();
          }
        }
      });
      endWhenEmpty();
    });
  }

 private:
  void endWhenEmpty() {
    if (isClosing_ && connections_.empty()) {
      patience_.cancel();
      signals_.cancel();
      context_.stop();
    }
  }

  void waitForSignal() {
    signals_.async_wait([this](const error_code& error, int) {
      if (!error) {
        onStop_();
        waitForSignal();
      }
    });
  }

  asio::awaitable<void> accept() {
    while (acceptor_.is_open()) {
      auto [error, socket] = co_await acceptor_.async_accept(kToken);
      if (error == asio::error::operation_aborted || !acceptor_.is_open()) {
        co_return;
      }
      if (error) {
        // out of descriptors: try again when one may be free
        core_->log().warn("cannot accept a connection: " + error.message());
        asio::steady_timer pause(context_, std::chrono::milliseconds(100));
        co_await pause.async_wait(kToken);
        continue;
      }
      begin(std::move(socket));
    }
  }

  void begin(tcp::socket socket) {
    const auto connection = std::make_shared<TcpConnection>(std::move(socket), *core_);
    const std::uint32_t bound = core_->options().limits.sessions;
    const std::string id = std::to_string(++sessionCount_);
    connections_.insert(connection);
    ++core_->sessionCount;
    connection->onClosed = [this, weak = std::weak_ptr(connection)] {
      connections_.erase(weak.lock());
      --core_->sessionCount;
      endWhenEmpty();
    };
    connection->start(std::make_shared<Session>(id, *core_, connection));
    if (connections_.size() > bound) {
      connection->send(std::make_shared<const std::string>(protocol::encodeError(
          {}, protocol::limitError("sessions", connections_.size(), bound, "Close one, or try again later."))));
      connection->closeWhenSent();
    }
  }

  ServerCore* core_;
  asio::io_context context_;
  tcp::acceptor acceptor_;
  asio::signal_set signals_;
  asio::steady_timer patience_;
  std::set<std::shared_ptr<TcpConnection>> connections_;
  std::function<void()> onStop_;
  std::uint64_t sessionCount_ = 0;
  std::uint16_t port_ = 0;
  bool isClosing_ = false;
};

Network::Network(ServerCore& core) : implementation_(std::make_unique<Implementation>(core)) {}
Network::~Network() = default;

bool Network::isLoopback(const std::string& host) {
  asio::io_context context;
  tcp::resolver resolver(context);
  error_code error;
  const auto found = resolver.resolve(host, "0", tcp::resolver::passive, error);
  if (error || found.empty()) {
    return host == "localhost";
  }
  return std::all_of(found.begin(), found.end(),
                     [](const auto& entry) { return entry.endpoint().address().is_loopback(); });
}

std::optional<std::string> Network::listen(const std::string& host, std::uint16_t port) {
  return implementation_->listen(host, port);
}

std::uint16_t Network::port() const {
  return implementation_->port();
}

void Network::run(bool handleSignals, std::function<void()> onStop) {
  implementation_->run(handleSignals, std::move(onStop));
}

void Network::stopAccepting() {
  implementation_->stopAccepting();
}

void Network::announceShutdown() {
  implementation_->announceShutdown();
}

void Network::close(std::chrono::milliseconds patience) {
  implementation_->close(patience);
}

}  // namespace espalier::server

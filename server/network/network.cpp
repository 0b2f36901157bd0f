#include "server/network/network.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <set>

#include "protocol/envelope.h"
#include "protocol/json_writer.h"
#include "server/network/http.h"
#include "server/network/listening.h"
#include "server/network/stream_connection.h"
#include "server/remote/freed_memory.h"
#include "server/server_core.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

using asio::ip::tcp;

constexpr std::string_view kUnix = "unix:";
// how often tokens are looked at
constexpr std::chrono::seconds kSweep{1};

}  // namespace

class Network::Implementation {
 public:
  explicit Implementation(ServerCore& core)
      : core_(&core),
        context_(1),
        acceptor_(context_),
        unixAcceptor_(context_),
        httpAcceptor_(context_),
        encryption_(asio::ssl::context::tls_server),
        signals_(context_),
        patience_(context_),
        sweep_(context_) {}

  ~Implementation() {
    // another server may listen on the path by now
    if (!unixPath_.empty() && identityOf(unixPath_) == unixFile_) {
      ::unlink(unixPath_.c_str());
    }
  }

  std::optional<std::string> listen() {
    const ServerOptions& options = core_->options();
    setBounds();
    isEncrypted_ = !options.certificateFile.empty();
    if (isEncrypted_) {
      if (auto problem = loadCertificate(encryption_, options.certificateFile, options.keyFile)) {
        return problem;
      }
    }
    if (options.host.starts_with(kUnix)) {
      const std::string path = options.host.substr(kUnix.size());
      if (auto problem = listenOnUnixSocket(unixAcceptor_, path)) {
        return problem;
      }
      unixPath_ = path;
      unixFile_ = identityOf(path);
    } else if (auto problem = listenOn(acceptor_, options.host, options.port, "--listen")) {
      return problem;
    }
    return options.httpHost.empty() ? std::nullopt
                                    : listenOn(httpAcceptor_, options.httpHost, options.httpPort, "--http");
  }

  [[nodiscard]] std::uint16_t port() const { return portOf(acceptor_); }
  [[nodiscard]] std::uint16_t httpPort() const { return portOf(httpAcceptor_); }

  void run(bool handleSignals, std::function<void()> onStop) {
    onStop_ = std::move(onStop);
    if (handleSignals) {
      signals_.add(SIGINT);
      signals_.add(SIGTERM);
      // tokens and limits from files and a certificate are read again; else a terminal that closes ends the server in
      // order, unless nohup wants it to go on
      struct sigaction hangUp {};
      if (readsAgain() || (::sigaction(SIGHUP, nullptr, &hangUp) == 0 && hangUp.sa_handler != SIG_IGN)) {
        signals_.add(SIGHUP);
      }
      waitForSignal();
    }
    sweep();
    if (acceptor_.is_open()) {
      asio::co_spawn(context_, accept(acceptor_, [this](tcp::socket socket) { admitStream(std::move(socket)); }),
                     asio::detached);
    }
    if (unixAcceptor_.is_open()) {
      asio::co_spawn(context_, accept(unixAcceptor_, [this](UnixSocket socket) { admitUnix(std::move(socket)); }),
                     asio::detached);
    }
    if (httpAcceptor_.is_open()) {
      asio::co_spawn(context_, accept(httpAcceptor_, [this](tcp::socket socket) { admitHttp(std::move(socket)); }),
                     asio::detached);
    }
    if (const auto& signal = core_->options().readySignal) {
      signal();
    }
    while (!context_.stopped()) {
      try {
        context_.run();
      } catch (const std::exception& exception) {
        // one connection's trouble is not the server's
        core_->log().error(std::string("internal error on the network thread: ") + exception.what());
      }
    }
  }

  void stopAccepting() {
    asio::post(context_, [this] {
      error_code ignored;
      acceptor_.close(ignored);
      unixAcceptor_.close(ignored);
      httpAcceptor_.close(ignored);
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
  /// Never more connections than there are descriptors for.
  void setBounds() {
    const ServerLimits& limits = core_->limits();
    const std::size_t descriptors = raiseDescriptorBound(AdmissionBounds::neededDescriptors(limits));
    admission_.setBounds(AdmissionBounds::of(limits, descriptors));
    if (const std::size_t sessions = admission_.bounds().sessions; sessions < limits.sessions) {
      core_->log().warn("the system allows " + std::to_string(descriptors) + " open descriptors, enough for " +
                        std::to_string(sessions) +
                        " sessions. Raise it with 'ulimit -n', or lower --limit sessions=N.");
    }
  }

  void endWhenEmpty() {
    if (isClosing_ && connections_.empty()) {
      patience_.cancel();
      sweep_.cancel();
      signals_.cancel();
      context_.stop();
    }
  }

  /// Ends sessions whose tokens no longer hold, also when their peers only watch. There is no timer for each token,
  /// because the wall clock may jump.
  void sweep() {
    sweep_.expires_after(kSweep);
    sweep_.async_wait([this](const error_code& error) {
      if (error) {
        return;
      }
      for (const auto& connection : std::set(connections_)) {
        connection->checkAccess();
      }
      core_->countDatabase();
      if (isHeapTrimDue()) {
        core_->pool().post({.run = [] { trimHeap(); }, .owner = "closing"});
      }
      if (const auto& signal = core_->options().aliveSignal) {
        signal();
      }
      sweep();
    });
  }

  /// Whether SIGHUP means that files have changed, and not that a terminal was closed.
  [[nodiscard]] bool readsAgain() const { return isEncrypted_ || core_->options().readAgain; }

  /// The returned function gives later connections the new certificate; open ones keep the old one. On a worker.
  tl::expected<std::function<void()>, std::string> readCertificateAgain() {
    const auto fresh = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_server);
    const ServerOptions& options = core_->options();
    if (auto problem = loadCertificate(*fresh, options.certificateFile, options.keyFile)) {
      return tl::unexpected(std::move(*problem));
    }
    return [this, fresh] {
      asio::post(context_, [this, fresh] {
        encryption_ = std::move(*fresh);
        core_->log().info("read the certificate again");
      });
    };
  }

  void waitForSignal() {
    signals_.async_wait([this](const error_code& error, int number) {
      if (error) {
        return;
      }
      core_->log().info(std::string("received ") + (number == SIGHUP   ? "SIGHUP"
                                                    : number == SIGINT ? "SIGINT"
                                                                       : "SIGTERM"));
      if (number == SIGHUP && readsAgain()) {
        const auto certificate = [this] { return readCertificateAgain(); };
        core_->readAgain(isEncrypted_ ? ServerCore::ReadMore(certificate) : nullptr,
                         [this] { asio::post(context_, [this] { setBounds(); }); });
      } else {
        onStop_();
      }
      waitForSignal();
    });
  }

  using UnixSocket = asio::local::stream_protocol::socket;

  [[nodiscard]] static std::uint16_t portOf(const tcp::acceptor& acceptor) {
    error_code error;
    const auto endpoint = acceptor.local_endpoint(error);
    return error ? std::uint16_t{0} : endpoint.port();
  }

  template <typename Acceptor, typename Take>
  asio::awaitable<void> accept(Acceptor& acceptor, Take take) {
    while (acceptor.is_open()) {
      auto [error, socket] = co_await acceptor.async_accept(kAsTuple);
      if (error == asio::error::operation_aborted || !acceptor.is_open()) {
        co_return;
      }
      if (error == asio::error::no_descriptors && admission_.evictOne()) {
        // the connection that has waited longest gave back its descriptor
        continue;
      }
      if (error) {
        core_->log().warn("cannot accept a connection: " + error.message());
        asio::steady_timer pause(context_, std::chrono::milliseconds(100));
        co_await pause.async_wait(kAsTuple);
        continue;
      }
      take(std::move(socket));
    }
  }

  static void prepare(tcp::socket& socket) {
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(asio::socket_base::keep_alive(true), ignored);
  }

  Accepted acceptedFrom(const tcp::socket& socket, Side side) {
    error_code error;
    const auto endpoint = socket.remote_endpoint(error);
    const bool isLocal = !error && endpoint.address().is_loopback();
    const std::string address = error ? "unknown" : endpoint.address().to_string();
    return {address + ":" + std::to_string(endpoint.port()), helloDeadline(),
            admission_.enter(side, isLocal ? std::string() : address)};
  }

  [[nodiscard]] std::chrono::steady_clock::time_point helloDeadline() const {
    return std::chrono::steady_clock::now() + std::chrono::milliseconds(core_->limits().handshakeMilliseconds);
  }

  void admitUnix(UnixSocket socket) {
    admit(std::make_shared<StreamConnection<UnixSocket>>(
        std::move(socket), *core_, Accepted{"unix", helloDeadline(), admission_.enter(Side::Protocol, {})}));
  }

  void admitStream(tcp::socket socket) {
    Accepted accepted = acceptedFrom(socket, Side::Protocol);
    prepare(socket);
    if (isEncrypted_) {
      using Encrypted = asio::ssl::stream<tcp::socket>;
      admit(std::make_shared<StreamConnection<Encrypted>>(Encrypted(std::move(socket), encryption_), *core_,
                                                          std::move(accepted)));
    } else {
      admit(std::make_shared<StreamConnection<tcp::socket>>(std::move(socket), *core_, std::move(accepted)));
    }
  }

  void admitHttp(tcp::socket socket) {
    Accepted accepted = acceptedFrom(socket, Side::Http);
    prepare(socket);
    HttpServices services{core_, [this](std::shared_ptr<PeerConnection> connection) { admit(std::move(connection)); }};
    serveHttp(std::move(socket), isEncrypted_ ? &encryption_ : nullptr, std::move(accepted), std::move(services));
  }

  /// Gives a session to a connection and keeps it until it is closed.
  void admit(std::shared_ptr<PeerConnection> connection) {
    connections_.insert(connection);
    connection->onClosed = [this, weak = std::weak_ptr(connection)] {
      connections_.erase(weak.lock());
      endWhenEmpty();
    };
    connection->start(std::make_shared<Session>(std::to_string(++connectionCount_), *core_, connection));
    if (connection->isBeyondAddressBound()) {
      const std::uint64_t bound = admission_.bounds().perAddress;
      connection->send(std::make_shared<const std::string>(protocol::encodeError(
          {}, protocol::limitError("connectionsPerAddress", bound + 1, bound, "Close one, or try again later."))));
      connection->closeWhenSent();
    }
  }

  ServerCore* core_;
  Admission admission_;  // connections hold places of it
  asio::io_context context_;
  tcp::acceptor acceptor_;
  asio::local::stream_protocol::acceptor unixAcceptor_;
  tcp::acceptor httpAcceptor_;
  asio::ssl::context encryption_;
  bool isEncrypted_ = false;
  std::string unixPath_;  // of our socket; empty: none
  std::optional<FileIdentity> unixFile_;
  asio::signal_set signals_;
  asio::steady_timer patience_;
  asio::steady_timer sweep_;
  std::set<std::shared_ptr<PeerConnection>> connections_;
  std::function<void()> onStop_;
  std::uint64_t connectionCount_ = 0;  // that there have been
  bool isClosing_ = false;
};

Network::Network(ServerCore& core) : implementation_(std::make_unique<Implementation>(core)) {}
Network::~Network() = default;

bool Network::isLoopback(const std::string& host) {
  if (host.starts_with(kUnix)) {
    return true;
  }
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

std::optional<std::string> Network::listen() {
  return implementation_->listen();
}

std::uint16_t Network::port() const {
  return implementation_->port();
}

std::uint16_t Network::httpPort() const {
  return implementation_->httpPort();
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

#include "server/network/network.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <set>

#include "protocol/envelope.h"
#include "protocol/json_writer.h"
#include "server/network/http.h"
#include "server/network/stream_connection.h"
#include "server/server_core.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

using asio::ip::tcp;

constexpr std::string_view kUnix = "unix:";
// peers at a time that are told that there is no room; more are closed without a word
constexpr std::uint64_t kMostRefused = 1'000;

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
        patience_(context_) {}

  ~Implementation() {
    if (!unixPath_.empty()) {
      ::unlink(unixPath_.c_str());
    }
  }

  std::optional<std::string> listen() {
    const ServerOptions& options = core_->options();
    if (auto problem = loadCertificate(options)) {
      return problem;
    }
    if (options.host.starts_with(kUnix)) {
      if (auto problem = listenOnUnixSocket(options.host.substr(kUnix.size()))) {
        return problem;
      }
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
      waitForSignal();
    }
    if (acceptor_.is_open()) {
      asio::co_spawn(context_, accept(acceptor_, [this](tcp::socket socket) { admitStream(std::move(socket)); }),
                     asio::detached);
    }
    if (unixAcceptor_.is_open()) {
      asio::co_spawn(
          context_,
          accept(unixAcceptor_,
                 [this](UnixSocket socket) {
                   admit(std::make_shared<StreamConnection<UnixSocket>>(std::move(socket), *core_, "unix", true));
                 }),
          asio::detached);
    }
    if (httpAcceptor_.is_open()) {
      asio::co_spawn(context_, accept(httpAcceptor_, [this](tcp::socket socket) { admitHttp(std::move(socket)); }),
                     asio::detached);
    }
    context_.run();
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

  using UnixSocket = asio::local::stream_protocol::socket;

  [[nodiscard]] static std::uint16_t portOf(const tcp::acceptor& acceptor) {
    error_code error;
    const auto endpoint = acceptor.local_endpoint(error);
    return error ? std::uint16_t{0} : endpoint.port();
  }

  std::optional<std::string> loadCertificate(const ServerOptions& options) {
    isEncrypted_ = !options.certificateFile.empty();
    if (!isEncrypted_) {
      return std::nullopt;
    }
    error_code error;
    encryption_.set_options(
        asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1, error);
    encryption_.use_certificate_chain_file(options.certificateFile, error);
    if (error) {
      return "the certificate '" + options.certificateFile + "' cannot be used: " + error.message() +
             ". ./dev certificate makes one for tests.";
    }
    encryption_.use_private_key_file(options.keyFile, asio::ssl::context::pem, error);
    if (error) {
      return "the key '" + options.keyFile + "' cannot be used: " + error.message() +
             ". Give --key the private key of the certificate.";
    }
    return std::nullopt;
  }

  std::optional<std::string> listenOn(tcp::acceptor& acceptor, const std::string& host, std::uint16_t port,
                                      const std::string& option) {
    error_code error;
    tcp::resolver resolver(context_);
    const auto found = resolver.resolve(host, std::to_string(port), tcp::resolver::passive, error);
    if (error || found.empty()) {
      return "cannot listen on '" + host + "': the address is unknown. Use 127.0.0.1 or an address of this machine.";
    }
    const tcp::endpoint endpoint = found.begin()->endpoint();
    acceptor.open(endpoint.protocol(), error);
    if (!error) {
      acceptor.set_option(tcp::acceptor::reuse_address(true), error);
      acceptor.bind(endpoint, error);
    }
    if (!error) {
      acceptor.listen(asio::socket_base::max_listen_connections, error);
    }
    if (error == asio::error::address_in_use) {
      return "cannot listen on " + host + ":" + std::to_string(port) + ": the port is in use. Choose another with " +
             option + ", or port 0 for a free one.";
    }
    if (error) {
      return "cannot listen on " + host + ":" + std::to_string(port) + ": " + error.message() +
             ". Choose another address with " + option + ".";
    }
    return std::nullopt;
  }

  std::optional<std::string> listenOnUnixSocket(const std::string& path) {
    error_code error;
    const asio::local::stream_protocol::endpoint endpoint(path);
    // what a killed server left behind is taken away, a living one is not
    UnixSocket probe(context_);
    probe.connect(endpoint, error);
    if (!error) {
      return "cannot listen on unix:" + path + ": another server does. Choose another path with --listen.";
    }
    if (error == asio::error::connection_refused) {
      ::unlink(path.c_str());
    }
    error.clear();
    unixAcceptor_.open(endpoint.protocol(), error);
    // only this user may connect
    const mode_t before = ::umask(0177);
    if (!error) {
      unixAcceptor_.bind(endpoint, error);
    }
    ::umask(before);
    if (!error) {
      unixAcceptor_.listen(asio::socket_base::max_listen_connections, error);
    }
    if (error) {
      return "cannot listen on unix:" + path + ": " + error.message() + ". Choose another path with --listen.";
    }
    unixPath_ = path;
    return std::nullopt;
  }

  template <typename Acceptor, typename Take>
  asio::awaitable<void> accept(Acceptor& acceptor, Take take) {
    while (acceptor.is_open()) {
      auto [error, socket] = co_await acceptor.async_accept(kAsTuple);
      if (error == asio::error::operation_aborted || !acceptor.is_open()) {
        co_return;
      }
      if (error) {
        // out of descriptors: try again when one may be free
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

  void admitStream(tcp::socket socket) {
    error_code error;
    const auto endpoint = socket.remote_endpoint(error);
    const std::string peerName =
        error ? "unknown" : endpoint.address().to_string() + ":" + std::to_string(endpoint.port());
    const bool isLocal = !error && endpoint.address().is_loopback();
    prepare(socket);
    if (isEncrypted_) {
      using Encrypted = asio::ssl::stream<tcp::socket>;
      admit(std::make_shared<StreamConnection<Encrypted>>(Encrypted(std::move(socket), encryption_), *core_, peerName,
                                                          isLocal));
    } else {
      admit(std::make_shared<StreamConnection<tcp::socket>>(std::move(socket), *core_, peerName, isLocal));
    }
  }

  void admitHttp(tcp::socket socket) {
    prepare(socket);
    HttpServices services{core_, [this](std::shared_ptr<PeerConnection> connection) { admit(std::move(connection)); }};
    if (isEncrypted_) {
      asio::co_spawn(context_,
                     serveHttps(asio::ssl::stream<tcp::socket>(std::move(socket), encryption_), std::move(services)),
                     asio::detached);
    } else {
      asio::co_spawn(context_, serveHttp(std::move(socket), std::move(services)), asio::detached);
    }
  }

  void admit(std::shared_ptr<PeerConnection> connection) {
    const std::uint32_t bound = core_->options().limits.sessions;
    const std::string id = std::to_string(++sessionCount_);
    // those that are only told that there is no room take none
    const bool isRefused = connections_.size() - refusedCount_ >= bound;
    connections_.insert(connection);
    std::uint64_t& count = isRefused ? refusedCount_ : admittedCount_;
    ++count;
    core_->sessionCount = static_cast<std::uint32_t>(admittedCount_);
    ++core_->metrics.sessions;
    connection->onClosed = [this, &count, weak = std::weak_ptr(connection)] {
      connections_.erase(weak.lock());
      --count;
      core_->sessionCount = static_cast<std::uint32_t>(admittedCount_);
      endWhenEmpty();
    };
    connection->start(std::make_shared<Session>(id, *core_, connection));
    if (isRefused && refusedCount_ > kMostRefused) {
      connection->closeNow();
    } else if (isRefused) {
      connection->send(std::make_shared<const std::string>(protocol::encodeError(
          {}, protocol::limitError("sessions", bound + 1, bound, "Close one, or try again later."))));
      connection->closeWhenSent();
    }
  }

  ServerCore* core_;
  asio::io_context context_;
  tcp::acceptor acceptor_;
  asio::local::stream_protocol::acceptor unixAcceptor_;
  tcp::acceptor httpAcceptor_;
  asio::ssl::context encryption_;
  bool isEncrypted_ = false;
  std::string unixPath_;  // of our socket; empty: none
  asio::signal_set signals_;
  asio::steady_timer patience_;
  std::set<std::shared_ptr<PeerConnection>> connections_;
  std::function<void()> onStop_;
  std::uint64_t sessionCount_ = 0;   // that there have been
  std::uint64_t admittedCount_ = 0;  // of connections_
  std::uint64_t refusedCount_ = 0;   // of connections_, which are being closed because there are too many
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

#include "server/remote/hosting/dial_bridge.h"

#include <array>
#include <boost/asio.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <charconv>
#include <cstring>
#include <functional>
#include <optional>
#include <thread>

#include "protocol/envelope.h"
#include "protocol/framing.h"
#include "protocol/json_text.h"
#include "server/remote/processes/line_channel.h"
#include "server/remote/tcp_or_tls_stream.h"

namespace espalier::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
constexpr auto kAsTuple = asio::as_tuple(asio::use_awaitable);
constexpr std::size_t kPieceBytes = 65'536;
using WebSocket = websocket::stream<TcpOrTlsStream, false>;
constexpr std::string_view kPath = "/espalier/1";

/// Bytes as they are.
template <typename From, typename To>
asio::awaitable<void> passOn(From& from, To& to) {
  const auto bytes = std::make_unique_for_overwrite<std::array<char, kPieceBytes>>();
  while (true) {
    const auto [error, count] = co_await from.async_read_some(asio::buffer(*bytes), kAsTuple);
    if (error) {
      co_return;
    }
    const auto [problem, written] = co_await asio::async_write(to, asio::buffer(bytes->data(), count), kAsTuple);
    if (problem) {
      co_return;
    }
  }
}

/// How many raw bytes follow a line.
std::size_t blockBytesOf(const std::string& line) {
  std::size_t bytes = 0;
  if (line.find("\"binBytes\"") != std::string::npos) {
    const std::string text = protocol::memberOf(line, "binBytes").value_or("0");
    std::from_chars(text.data(), text.data() + text.size(), bytes);
  }
  return bytes;
}

/// Lines with their blocks, as frames.
asio::awaitable<void> sendFrames(tcp::socket& near, WebSocket& far) {
  std::string received;
  while (true) {
    // one line
    const auto [error, length] = co_await asio::async_read_until(near, asio::dynamic_buffer(received), '\n', kAsTuple);
    if (error) {
      co_return;
    }
    const std::size_t whole = length + blockBytesOf(received.substr(0, length - 1));
    if (received.size() < whole) {
      const auto [problem, count] = co_await asio::async_read(
          near, asio::dynamic_buffer(received), asio::transfer_exactly(whole - received.size()), kAsTuple);
      if (problem) {
        co_return;
      }
    }
    const bool isBinary = whole > length;
    far.binary(isBinary);
    const std::string frame =
        isBinary ? protocol::binaryFrame(received.substr(0, whole)) : received.substr(0, length - 1);
    received.erase(0, whole);
    if (frame.empty()) {
      continue;
    }
    const auto [problem, written] = co_await far.async_write(asio::buffer(frame), kAsTuple);
    if (problem) {
      co_return;
    }
  }
}

/// The bytes of a stream for a frame.
std::string lineOf(std::string_view frame, bool isBinary) {
  if (!isBinary) {
    return std::string(frame) + "\n";
  }
  // length of the JSON, JSON, zeros up to a multiple of 8, blocks
  std::uint32_t length = 0;
  if (frame.size() < sizeof(length)) {
    return "\n";
  }
  std::memcpy(&length, frame.data(), sizeof(length));
  const std::size_t end = std::min(frame.size(), sizeof(length) + std::size_t{length});
  const std::size_t blocks = std::min(frame.size(), (end + 7) / 8 * 8);
  return std::string(frame.substr(sizeof(length), end - sizeof(length))) + "\n" + std::string(frame.substr(blocks));
}

asio::awaitable<void> receiveFrames(tcp::socket& near, WebSocket& far) {
  beast::flat_buffer buffer;
  while (true) {
    const auto [error, count] = co_await far.async_read(buffer, kAsTuple);
    if (error) {
      co_return;
    }
    const std::string line = lineOf({static_cast<const char*>(buffer.data().data()), buffer.size()}, far.got_binary());
    buffer.consume(buffer.size());
    const auto [problem, written] = co_await asio::async_write(near, asio::buffer(line), kAsTuple);
    if (problem) {
      co_return;
    }
  }
}

}  // namespace

class DialBridge::Implementation {
 public:
  explicit Implementation(const Options& options) : options_(options) {}
  ~Implementation() {
    context_.stop();
    if (thread_.joinable()) {
      thread_.join();
    }
  }

  std::optional<std::string> open(const std::string& address) {
    const std::size_t scheme = address.find("://");
    const std::string kind = scheme == std::string::npos ? "unix" : address.substr(0, scheme);
    std::optional<std::string> outcome =
        "there was no answer within " + std::to_string(options_.connectTimeout.count()) + " ms";
    asio::co_spawn(
        context_,
        [&]() -> asio::awaitable<void> {
          // not in one expression: g++ 12 makes wrong code of that
          if (kind == "unix") {
            outcome = co_await dialUnixSocket(address.substr(address.find(':') + 1));
          } else {
            outcome = co_await dial(kind, address.substr(scheme + 3));
          }
        },
        asio::detached);
    context_.run_for(options_.connectTimeout);
    if (outcome) {
      return "Cannot connect to " + address + ": " + *outcome + ". " + remedy_;
    }
    // the client comes by itself, and is the only one
    acceptor_.open(tcp::v4());
    acceptor_.bind({asio::ip::address_v4::loopback(), 0});
    acceptor_.listen(1);
    asio::co_spawn(context_, acceptOne(), asio::detached);
    context_.restart();
    thread_ = std::thread([this] { context_.run(); });
    return std::nullopt;
  }

  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()); }

 private:
  using Problem = std::optional<std::string>;
  std::string remedy_ = "Start the server (espalier serve) or correct the address.";

  asio::awaitable<Problem> dialUnixSocket(std::string path) {
    auto socket = std::make_shared<asio::local::stream_protocol::socket>(context_);
    const auto [error] = co_await socket->async_connect(asio::local::stream_protocol::endpoint(path), kAsTuple);
    if (error) {
      co_return error.message();
    }
    pump_ = [this, socket](bool isTowardsFar) {
      return isTowardsFar ? passOn(near_, *socket) : passOn(*socket, near_);
    };
    co_return std::nullopt;
  }

  asio::awaitable<Problem> dial(std::string kind, std::string place) {
    std::string host;
    std::uint16_t port = 0;
    // a path behind the port is that of the WebSocket
    const std::size_t slash = place.find('/');
    const std::string path = slash == std::string::npos ? std::string(kPath) : place.substr(slash);
    place = place.substr(0, slash);
    if (!splitAddress(place, host, port) || port == 0) {
      co_return "it is not of the form " + kind + "://HOST:PORT";
    }
    tcp::resolver resolver(context_);
    const auto [unknown, found] = co_await resolver.async_resolve(host, std::to_string(port), kAsTuple);
    if (unknown) {
      co_return unknown.message();
    }
    beast::tcp_stream plain(context_);
    const auto [error, endpoint] = co_await asio::async_connect(plain.socket(), found, kAsTuple);
    if (error) {
      co_return error.message();
    }
    plain.socket().set_option(tcp::no_delay(true));
    if (kind == "ws") {
      co_return co_await upgrade(TcpOrTlsStream(std::move(plain)), place, path);
    }

    tls_.set_default_verify_paths();
    error_code unreadable;
    if (!options_.trustedFile.empty()) {
      tls_.load_verify_file(options_.trustedFile, unreadable);
    }
    if (unreadable) {
      remedy_ = "Give a file of certificates in the form PEM.";
      co_return "the certificates in " + options_.trustedFile + " cannot be read (" + unreadable.message() + ")";
    }
    TcpOrTlsStream encrypted(TcpOrTlsStream::Tls(std::move(plain), tls_));
    encrypted.tls().set_verify_mode(asio::ssl::verify_peer);
    encrypted.tls().set_verify_callback(asio::ssl::host_name_verification(host));
    SSL_set_tlsext_host_name(encrypted.tls().native_handle(), host.c_str());
    const auto [untrusted] = co_await encrypted.tls().async_handshake(asio::ssl::stream_base::client, kAsTuple);
    if (untrusted) {
      const bool isCertificate = untrusted.message().find("certificate") != std::string::npos;
      remedy_ = isCertificate ? "Trust the certificate of the server with --trust FILE.pem, and use a name that it has."
                              : "If the server is not encrypted, leave out tls://, or write ws:// instead of wss://.";
      co_return untrusted.message();
    }
    if (kind == "wss") {
      co_return co_await upgrade(std::move(encrypted), place, path);
    }
    auto far = std::make_shared<TcpOrTlsStream>(std::move(encrypted));
    pump_ = [this, far](bool isTowardsFar) { return isTowardsFar ? passOn(near_, *far) : passOn(*far, near_); };
    co_return std::nullopt;
  }

  asio::awaitable<Problem> upgrade(TcpOrTlsStream stream, std::string host, std::string path) {
    const auto far = std::make_shared<WebSocket>(std::move(stream));
    far->read_message_max(0);
    const auto [refused] = co_await far->async_handshake(host, path, kAsTuple);
    if (refused) {
      remedy_ = "Give the address of its HTTP side (espalier serve --http), with wss:// when it is encrypted.";
      co_return refused.message();
    }
    pump_ = [this, far](bool isTowardsFar) {
      return isTowardsFar ? sendFrames(near_, *far) : receiveFrames(near_, *far);
    };
    co_return std::nullopt;
  }

  asio::awaitable<void> acceptOne() {
    const auto [error] = co_await acceptor_.async_accept(near_, kAsTuple);
    error_code ignored;
    acceptor_.cancel(ignored);
    if (error) {
      co_return;
    }
    near_.set_option(tcp::no_delay(true), ignored);
    // when one direction ends, the client is let go
    const auto run = [this](bool isTowardsFar) {
      asio::co_spawn(context_, pump_(isTowardsFar), [this](const std::exception_ptr&) {
        error_code closed;
        near_.close(closed);
      });
    };
    run(true);
    run(false);
  }

  Options options_;
  asio::io_context context_;
  asio::ssl::context tls_{asio::ssl::context::tls_client};
  tcp::acceptor acceptor_{context_};
  tcp::socket near_{context_};
  std::function<asio::awaitable<void>(bool isTowardsFar)> pump_;  // owns the far side
  std::thread thread_;
};

DialBridge::DialBridge(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
DialBridge::~DialBridge() = default;

bool DialBridge::isFor(const std::string& address) {
  return address.starts_with("tls://") || address.starts_with("ws://") || address.starts_with("wss://") ||
         address.starts_with("unix:");
}

tl::expected<std::unique_ptr<DialBridge>, std::string> DialBridge::open(const std::string& address,
                                                                        const Options& options) {
  auto implementation = std::make_unique<Implementation>(options);
  if (auto problem = implementation->open(address)) {
    return tl::unexpected(std::move(*problem));
  }
  return std::unique_ptr<DialBridge>(new DialBridge(std::move(implementation)));
}

std::string DialBridge::address() const {
  return implementation_->address();
}

}  // namespace espalier::server

#include "server/network/http.h"

#include <netinet/tcp.h>

#include <algorithm>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "server/network/downloads.h"
#include "server/network/http_pages.h"
#include "server/remote/tcp_or_tls_stream.h"

namespace espalier::server {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Request = http::request<http::empty_body>;

constexpr std::size_t kRequestBytes = 16'384;
// only the page's own script, styles in the page, images that the script makes, and the WebSocket of this server
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
// for each request after the first, and for each part of an answer that the peer reads
constexpr std::chrono::seconds kIdle{60};
// of one connection
constexpr int kMostRequests = 1'000;

/// Messages over a WebSocket: a text frame each, or a binary frame with blocks.
class WebSocketConnection final : public PeerConnection {
 public:
  /// `upgrade`: the request that asked for it.
  WebSocketConnection(TcpOrTlsStream stream, Request upgrade, ServerCore& core, Accepted accepted)
      : PeerConnection(stream.get_executor(), core, std::move(accepted)),
        stream_(std::move(stream)),
        upgrade_(std::move(upgrade)) {
    beast::get_lowest_layer(stream_).expires_never();
    stream_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  }

 protected:
  asio::awaitable<bool> prepare() override {
    const auto [error] = co_await stream_.async_accept(upgrade_, kAsTuple);
    co_return !error;
  }

  asio::awaitable<bool> receive() override {
    const protocol::FrameLimits limits = frameLimits();
    const std::size_t most = isGreeted() ? limits.lineBytes + limits.blockBytes : limits.lineBytes;
    stream_.read_message_max(most);
    // in parts: bytes of a message that has not come whole are counted
    do {
      const auto [error, count] = co_await stream_.async_read_some(buffer_, kPartBytes, kAsTuple);
      if (error == websocket::error::message_too_big) {
        lose(protocol::limitError("lineBytes", most + 1, limits.lineBytes,
                                  "Send smaller messages; the connection is closed."));
        co_return isReading();
      }
      if (error) {
        co_return false;
      }
      PeerConnection::count(count);
      if (!hold(buffer_.size())) {
        buffer_ = {};
        co_return true;
      }
    } while (!stream_.is_message_done());
    const Decode decode = [this, bound = limits.lineBytes, isBinary = stream_.got_binary(),
                           areBlocksAllowed = areBlocksAgreed()](std::optional<protocol::Error>& problem) {
      return decodeFrame(bound, isBinary, areBlocksAllowed, problem);
    };
    if (isReading() && buffer_.size() > kBigMessage) {
      co_await handOnWorker(decode);
    } else if (isReading()) {
      std::optional<protocol::Error> problem;
      if (const auto read = decode(problem)) {
        hand(*read, buffer_.size());
      } else {
        lose(*problem);
      }
    }
    buffer_.consume(buffer_.size());
    // memory of one big message is not kept while the peer is silent
    if (buffer_.capacity() > kBigMessage) {
      buffer_.shrink_to_fit();
    }
    bulk_.rest();
    (void)hold(0);
    co_return true;
  }

  asio::awaitable<bool> write(const Batch& messages) override {
    for (const auto& message : messages) {
      const bool isBinary = protocol::hasBlocks(*message);
      stream_.binary(isBinary);
      const std::string frame = isBinary ? protocol::binaryFrame(*message) : message->substr(0, message->size() - 1);
      const auto [error, count] = co_await stream_.async_write(asio::buffer(frame), kAsTuple);
      if (error) {
        co_return false;
      }
    }
    co_return true;
  }

  void shutdownSend() override {
    stream_.async_close(websocket::close_code::normal, [self = shared_from_this()](const error_code&) {});
  }
  void closeTransport() override { beast::get_lowest_layer(stream_).close(); }

 private:
  static constexpr std::size_t kPartBytes = 262'144;

  /// The message in the buffer, or a problem.
  std::optional<protocol::MessageReader::Read> decodeFrame(std::size_t bound, bool isBinary, bool areBlocksAllowed,
                                                           std::optional<protocol::Error>& problem) {
    const std::string_view frame(static_cast<const char*>(buffer_.data().data()), buffer_.size());
    if (!isBinary && frame.size() > bound) {
      problem =
          protocol::limitError("lineBytes", frame.size(), bound, "Send smaller messages; the connection is closed.");
      return std::nullopt;
    }
    return protocol::readFrame(frame, isBinary, areBlocksAllowed, bulk_, problem);
  }

  // without compression: what a peer sends costs its own size
  websocket::stream<TcpOrTlsStream, false> stream_;
  Request upgrade_;
  beast::flat_buffer buffer_;
  protocol::BulkTextReader bulk_;
};

using Response = http::response<http::span_body<const char>>;

std::string fieldOf(const Request& request, http::field name) {
  const auto value = request[name];
  return {value.data(), value.size()};
}

/// The answer to a request; it refers to the bytes of the page.
Response responseOf(const HttpPage& page, const Request& request, bool isMoreAllowed) {
  Response response{static_cast<http::status>(page.status), request.version()};
  response.set(http::field::server, "espalier");
  response.set(http::field::content_type, page.type);
  response.set("X-Content-Type-Options", "nosniff");
  if (page.type.starts_with("text/html")) {
    response.set("Content-Security-Policy", page.policy.empty() ? std::string(kPolicy) : page.policy);
  }
  if (!page.fileName.empty()) {
    std::string name = page.fileName;
    // a quote or an unprintable character would end the header
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c < ' ' || c == '"' || c == '\\' || c > '~'; }, '_');
    response.set(http::field::content_disposition, "attachment; filename=\"" + name + "\"");
  }
  if (page.status == 401) {
    response.set(http::field::www_authenticate, "Bearer");
  }
  response.keep_alive(request.keep_alive() && isMoreAllowed);
  std::string_view body = page.body;
  if (page.file != nullptr) {
    // a browser asks each time and gets only what it does not have
    response.set(http::field::cache_control, "no-cache");
    response.set(http::field::etag, page.file->tag);
    body = page.file->content;
    if (!page.file->packed.empty()) {
      response.set(http::field::vary, "Accept-Encoding");
      if (acceptsGzip(fieldOf(request, http::field::accept_encoding))) {
        response.set(http::field::content_encoding, "gzip");
        body = page.file->packed;
      }
    }
    if (hasFile(fieldOf(request, http::field::if_none_match), page.file->tag)) {
      response.result(http::status::not_modified);
      response.erase(http::field::content_encoding);
      body = {};
    }
  }
  response.body() = {body.data(), body.size()};
  response.prepare_payload();
  if (request.method() == http::verb::head) {
    response.body() = {};
  }
  return response;
}

/// Whether the other end of a connection has closed it, or at least sends nothing more.
bool hasLeft(tcp::socket& socket) {
  ::tcp_info information{};
  ::socklen_t size = sizeof(information);
  return ::getsockopt(socket.native_handle(), IPPROTO_TCP, TCP_INFO, &information, &size) == 0 &&
         information.tcpi_state != TCP_ESTABLISHED;
}

/// The download is made on a worker; meanwhile the connection waits. Nothing when the peer has gone: then it is given
/// up.
asio::awaitable<std::optional<HttpPage>> download(DownloadPath path, Account& account, ServerCore& core,
                                                  tcp::socket& socket) {
  struct Waiting {
    asio::steady_timer done;
    std::optional<HttpPage> page;
  };
  constexpr std::chrono::milliseconds kLook{200};
  const auto executor = co_await asio::this_coro::executor;
  const auto waiting = std::make_shared<Waiting>(Waiting{asio::steady_timer(executor), std::nullopt});
  const auto giveUp = makeDownload(core, account, path, [waiting, executor](HttpPage page) {
    asio::post(executor, [waiting, page = std::move(page)]() mutable {
      waiting->page = std::move(page);
      waiting->done.cancel();
    });
  });
  while (!waiting->page) {
    waiting->done.expires_after(kLook);
    co_await waiting->done.async_wait(kAsTuple);
    if (!waiting->page && hasLeft(socket)) {
      giveUp();
      co_return std::nullopt;
    }
  }
  co_return std::move(waiting->page);
}

constexpr std::string_view kText = "text/plain; charset=utf-8";

/// One connection of the HTTP side. Its coroutine keeps it.
class HttpConnection final : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(TcpOrTlsStream stream, Accepted accepted, HttpServices services)
      : stream_(std::move(stream)), accepted_(std::move(accepted)), services_(std::move(services)) {}

  void start() {
    accepted_.place->onEvicted([weak = weak_from_this()] {
      if (const auto self = weak.lock()) {
        self->lowest().close();
      }
    });
    asio::co_spawn(
        stream_.get_executor(), [self = shared_from_this()] { return self->serve(); }, asio::detached);
  }

 private:
  beast::tcp_stream& lowest() { return beast::get_lowest_layer(stream_); }

  asio::awaitable<void> serve() {
    lowest().expires_at(accepted_.deadline);
    if (stream_.isEncrypted()) {
      const auto [error] = co_await stream_.tls().async_handshake(asio::ssl::stream_base::server, kAsTuple);
      if (error) {
        co_return;
      }
    }
    error_code unknown;
    isLoopback_ = lowest().socket().local_endpoint(unknown).address().is_loopback();
    for (int count = 1; count <= kMostRequests; ++count) {
      http::request_parser<http::empty_body> parser;
      parser.header_limit(kRequestBytes);
      const auto [error, bytes] = co_await http::async_read_header(stream_, buffer_, parser, kAsTuple);
      const bool isTooLong = error == http::error::header_limit || error == http::error::buffer_overflow;
      if (isTooLong || (!error && !parser.is_done())) {
        // of a request that is too long, or has a body, the rest is not read
        const HttpPage page{isTooLong ? 431U : 413U, std::string(kText),
                            isTooLong ? "A request may have " + std::to_string(kRequestBytes) + " bytes.\n"
                                      : "Only GET and HEAD are answered here, without a body.\n"};
        (void)co_await write(responseOf(page, parser.get(), false));
        error_code ignored;
        lowest().socket().shutdown(asio::socket_base::shutdown_send, ignored);
        co_return;
      }
      if (error) {
        co_return;
      }
      Request request = parser.release();
      if (isUpgradeAllowed(request)) {
        services_.admit(std::make_shared<WebSocketConnection>(std::move(stream_), std::move(request), *services_.core,
                                                              std::move(accepted_)));
        co_return;
      }
      lowest().expires_never();
      // its memory is counted until it is written
      const std::optional<HttpPage> page = co_await pageFor(request);
      if (!page) {
        co_return;
      }
      const bool isKept = co_await write(responseOf(*page, request, count < kMostRequests));
      if (!isKept) {
        error_code ignored;
        lowest().socket().shutdown(asio::socket_base::shutdown_send, ignored);
        co_return;
      }
      accepted_.place->renew();
      lowest().expires_after(kIdle);
    }
  }

  [[nodiscard]] bool isOfProtocol(const Request& request) const {
    return websocket::is_upgrade(request) && request.target() == "/espalier/1";
  }

  [[nodiscard]] bool isUpgradeAllowed(const Request& request) const {
    return isOfProtocol(request) &&
           isOriginAllowed(fieldOf(request, http::field::origin), fieldOf(request, http::field::host), isLoopback_,
                           services_.core->options().allowedOrigins);
  }

  /// Nothing when the peer has gone meanwhile.
  asio::awaitable<std::optional<HttpPage>> pageFor(const Request& request) {
    if (accepted_.place->isBeyondAddressBound()) {
      co_return HttpPage{503, std::string(kText),
                         "Your address has more connections than connectionsPerAddress=" +
                             std::to_string(accepted_.place->bounds().perAddress) + " allows. Close one.\n"};
    }
    if (isOfProtocol(request)) {
      const std::string origin = fieldOf(request, http::field::origin);
      co_return HttpPage{
          403, std::string(kText),
          "Pages from " + origin + " may not connect; start the server with --allow-origin " + origin + ".\n"};
    }
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      co_return HttpPage{405, std::string(kText), "Only GET and HEAD are answered here.\n"};
    }
    const std::string target(request.target().data(), request.target().size());
    auto path = downloadPathOf(target);
    if (!path) {
      co_return pageOf(target, *services_.core);
    }
    if (!isHostAllowed(fieldOf(request, http::field::host), isLoopback_)) {
      co_return HttpPage{403, std::string(kText), "Downloads are for this machine: ask localhost for them.\n"};
    }
    const Access& access = services_.core->access();
    const auto grant = downloadGrant(fieldOf(request, http::field::authorization), access);
    if (!grant) {
      co_return HttpPage{401, std::string(kText), grant.error() + "\n"};
    }
    if (access.hasTokens()) {
      // strangers do not end the download; without a place of its own it waits like any other connection
      (void)accepted_.place->trust();
    }
    Account& account = services_.core->accounts().of(grant->token == nullptr ? std::string() : grant->token->name);
    co_return co_await download(std::move(*path), account, *services_.core, lowest().socket());
  }

  /// Writes in parts: a peer that reads nothing for kIdle is given up. Whether the connection is kept for more.
  asio::awaitable<bool> write(Response response) {
    http::response_serializer<Response::body_type> serializer(response);
    while (!serializer.is_done()) {
      lowest().expires_after(kIdle);
      const auto [error, count] = co_await http::async_write_some(stream_, serializer, kAsTuple);
      if (error) {
        co_return false;
      }
    }
    co_return response.keep_alive();
  }

  TcpOrTlsStream stream_;
  Accepted accepted_;
  HttpServices services_;
  beast::flat_buffer buffer_{kRequestBytes};
  bool isLoopback_ = false;  // it came in on this machine's own address
};

}  // namespace

void serveHttp(tcp::socket socket, asio::ssl::context* encryption, Accepted accepted, HttpServices services) {
  beast::tcp_stream plain(std::move(socket));
  TcpOrTlsStream stream =
      encryption == nullptr ? TcpOrTlsStream(std::move(plain)) : TcpOrTlsStream({std::move(plain), *encryption});
  std::make_shared<HttpConnection>(std::move(stream), std::move(accepted), std::move(services))->start();
}

}  // namespace espalier::server

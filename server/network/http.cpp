#include "server/network/http.h"

#include <algorithm>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>

#include "server/network/downloads.h"
#include "server/network/http_pages.h"

namespace espalier::server {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Request = http::request<http::empty_body>;

constexpr std::size_t kRequestBytes = 16'384;
constexpr std::chrono::seconds kIdle{60};

/// Messages over a WebSocket: a text frame each, or a binary frame with blocks.
template <typename Stream>
class WebSocketConnection final : public PeerConnection {
 public:
  WebSocketConnection(websocket::stream<Stream> stream, ServerCore& core, std::string peerName, bool isLocal)
      : PeerConnection(stream.get_executor(), core, std::move(peerName), isLocal), stream_(std::move(stream)) {
    const protocol::FrameLimits limits = frameLimits();
    stream_.read_message_max(limits.lineBytes + limits.blockBytes);
  }

 protected:
  asio::awaitable<bool> receive() override {
    const auto [error, count] = co_await stream_.async_read(buffer_, kAsTuple);
    if (error == websocket::error::message_too_big) {
      const protocol::FrameLimits limits = frameLimits();
      lose(protocol::limitError("lineBytes", limits.lineBytes + limits.blockBytes + 1, limits.lineBytes,
                                "Send smaller messages; the connection is closed."));
      co_return isReading();
    }
    if (error) {
      co_return false;
    }
    PeerConnection::count(count);
    const std::string_view frame(static_cast<const char*>(buffer_.data().data()), buffer_.size());
    if (isReading()) {
      take(frame);
    }
    buffer_.consume(buffer_.size());
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
  void closeTransport() override {
    error_code ignored;
    beast::get_lowest_layer(stream_).shutdown(asio::socket_base::shutdown_both, ignored);
    beast::get_lowest_layer(stream_).close(ignored);
  }

 private:
  void take(std::string_view frame) {
    if (!stream_.got_binary() && frame.size() > frameLimits().lineBytes) {
      lose(protocol::limitError("lineBytes", frame.size(), frameLimits().lineBytes,
                                "Send smaller messages; the connection is closed."));
      return;
    }
    std::optional<protocol::Error> problem;
    const auto read = protocol::readFrame(frame, stream_.got_binary(), areBlocksAgreed(), bulk_, problem);
    if (read) {
      hand(*read);
    } else {
      lose(*problem);
    }
  }

  websocket::stream<Stream> stream_;
  beast::flat_buffer buffer_;
  protocol::BulkTextReader bulk_;
};

http::response<http::string_body> responseOf(const HttpPage& page, const Request& request) {
  http::response<http::string_body> response{static_cast<http::status>(page.status), request.version()};
  response.set(http::field::server, "espalier");
  response.set(http::field::content_type, page.type);
  response.set("X-Content-Type-Options", "nosniff");
  if (page.type.starts_with("text/html")) {
    // its own script, styles in the page, images made by the script, and the WebSocket of this server: nothing else
    response.set("Content-Security-Policy",
                 "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
                 "connect-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  }
  if (!page.fileName.empty()) {
    std::string name = page.fileName;
    // quotes and what is not printable would end the field
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c < ' ' || c == '"' || c == '\\' || c > '~'; }, '_');
    response.set(http::field::content_disposition, "attachment; filename=\"" + name + "\"");
  }
  if (page.status == 401) {
    response.set(http::field::www_authenticate, "Bearer");
  }
  response.keep_alive(request.keep_alive());
  response.body() = page.body;
  response.prepare_payload();
  if (request.method() == http::verb::head) {
    response.body().clear();
  }
  return response;
}

std::string fieldOf(const Request& request, http::field name) {
  const auto value = request[name];
  return {value.data(), value.size()};
}

/// The download is made on a worker; meanwhile the connection waits.
asio::awaitable<HttpPage> download(DownloadPath path, ServerCore& core) {
  struct Waiting {
    asio::steady_timer done;
    std::optional<HttpPage> page;
  };
  const auto executor = co_await asio::this_coro::executor;
  const auto waiting = std::make_shared<Waiting>(Waiting{asio::steady_timer(executor), std::nullopt});
  waiting->done.expires_at(std::chrono::steady_clock::time_point::max());
  makeDownload(core, path, [waiting, executor](HttpPage page) {
    asio::post(executor, [waiting, page = std::move(page)]() mutable {
      waiting->page = std::move(page);
      waiting->done.cancel();
    });
  });
  while (!waiting->page) {
    co_await waiting->done.async_wait(kAsTuple);
  }
  co_return std::move(*waiting->page);
}

asio::awaitable<HttpPage> answerTo(const Request& request, ServerCore& core, bool isLoopback) {
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    co_return HttpPage{405, "text/plain; charset=utf-8", "Only GET and HEAD are answered here.\n"};
  }
  const std::string target(request.target().data(), request.target().size());
  auto path = downloadPathOf(target);
  if (!path) {
    co_return pageOf(target, core);
  }
  if (!isHostAllowed(fieldOf(request, http::field::host), isLoopback)) {
    co_return HttpPage{403, "text/plain; charset=utf-8", "Downloads are for this machine: ask localhost for them.\n"};
  }
  if (!mayDownload(fieldOf(request, http::field::authorization), core.options().token)) {
    co_return HttpPage{401, "text/plain; charset=utf-8",
                       "Downloads need the server's token: Authorization: Bearer TOKEN.\n"};
  }
  co_return co_await download(std::move(*path), core);
}

/// Makes a session of the connection.
template <typename Stream>
asio::awaitable<void> upgrade(Stream stream, Request request, const HttpServices& services) {
  error_code ignored;
  const auto endpoint = beast::get_lowest_layer(stream).remote_endpoint(ignored);
  const std::string peerName = endpoint.address().to_string() + ":" + std::to_string(endpoint.port());
  const bool isLocal = endpoint.address().is_loopback();
  websocket::stream<Stream> socket(std::move(stream));
  socket.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  const auto [error] = co_await socket.async_accept(request, kAsTuple);
  if (!error) {
    services.admit(std::make_shared<WebSocketConnection<Stream>>(std::move(socket), *services.core, peerName, isLocal));
  }
}

template <typename Stream>
asio::awaitable<void> serve(Stream stream, HttpServices services) {
  beast::flat_buffer buffer(kRequestBytes);
  // a peer that sends its request byte by byte does not keep the connection
  asio::steady_timer patience(stream.get_executor());
  const auto limit = [&patience, &stream](std::chrono::milliseconds time) {
    patience.expires_after(time);
    patience.async_wait([&stream](const error_code& error) {
      if (!error) {
        error_code ignored;
        beast::get_lowest_layer(stream).close(ignored);
      }
    });
  };
  bool isFirst = true;
  error_code unknown;
  const bool isLoopback = beast::get_lowest_layer(stream).local_endpoint(unknown).address().is_loopback();
  while (true) {
    limit(isFirst ? std::chrono::milliseconds(services.core->options().limits.handshakeMilliseconds) : kIdle);
    isFirst = false;
    http::request_parser<http::empty_body> parser;
    parser.header_limit(kRequestBytes);
    const auto [error, count] = co_await http::async_read(stream, buffer, parser, kAsTuple);
    patience.cancel();
    if (error) {
      co_return;
    }
    Request request = parser.release();
    HttpPage page;
    if (websocket::is_upgrade(request) && request.target() == "/espalier/1") {
      const std::string origin = fieldOf(request, http::field::origin);
      if (isOriginAllowed(origin, fieldOf(request, http::field::host), isLoopback,
                          services.core->options().allowedOrigins)) {
        co_await upgrade(std::move(stream), std::move(request), services);
        co_return;
      }
      page = {403, "text/plain; charset=utf-8",
              "Pages from " + origin + " may not connect; start the server with --allow-origin " + origin + ".\n"};
    } else {
      page = co_await answerTo(request, *services.core, isLoopback);
    }
    auto response = responseOf(page, request);
    const auto [writeError, written] = co_await http::async_write(stream, response, kAsTuple);
    if (writeError || !response.keep_alive()) {
      error_code ignored;
      beast::get_lowest_layer(stream).shutdown(asio::socket_base::shutdown_send, ignored);
      co_return;
    }
  }
}

}  // namespace

asio::awaitable<void> serveHttp(tcp::socket socket, HttpServices services) {
  return serve(std::move(socket), std::move(services));
}

asio::awaitable<void> serveHttps(asio::ssl::stream<tcp::socket> stream, HttpServices services) {
  const auto [error] = co_await stream.async_handshake(asio::ssl::stream_base::server, kAsTuple);
  if (!error) {
    co_await serve(std::move(stream), std::move(services));
  }
}

}  // namespace espalier::server

#pragma once

#include <array>
#include <boost/asio/any_completion_handler.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <optional>
#include <utility>
#include <variant>

namespace espalier::server {

/// A TCP stream with time limits, encrypted (TLS) or not: an AsyncStream of Asio. One type for both, and one type of
/// handler below it, so that the templates of Beast above and those of OpenSSL below are compiled once. Only for the
/// files that know the network library.
class TcpOrTlsStream {
 public:
  using Tcp = boost::beast::tcp_stream;
  using Tls = boost::asio::ssl::stream<Tcp>;
  using executor_type = Tcp::executor_type;
  using error_code = boost::system::error_code;

  explicit TcpOrTlsStream(Tcp stream) : stream_(std::move(stream)) {}
  explicit TcpOrTlsStream(Tls stream) : stream_(std::move(stream)) {}

  [[nodiscard]] bool isEncrypted() const { return std::holds_alternative<Tls>(stream_); }
  [[nodiscard]] executor_type get_executor() { return next_layer().get_executor(); }
  /// The layer that Beast takes for the lowest one.
  [[nodiscard]] Tcp& next_layer() {
    return isEncrypted() ? std::get<Tls>(stream_).next_layer() : std::get<Tcp>(stream_);
  }
  /// Only of an encrypted stream.
  [[nodiscard]] Tls& tls() { return std::get<Tls>(stream_); }

  template <typename Buffers, typename Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return start<boost::asio::mutable_buffer>(buffers, std::forward<Token>(token), [this](const auto& few, auto done) {
      std::visit([&](auto& stream) { stream.async_read_some(few, std::move(done)); }, stream_);
    });
  }

  template <typename Buffers, typename Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return start<boost::asio::const_buffer>(buffers, std::forward<Token>(token), [this](const auto& few, auto done) {
      std::visit([&](auto& stream) { stream.async_write_some(few, std::move(done)); }, stream_);
    });
  }

  /// How Beast ends a WebSocket: with TLS by its farewell, without it by waiting for the end of what the peer sends.
  template <typename Handler>
  friend void async_teardown(boost::beast::role_type role, TcpOrTlsStream& stream, Handler&& handler) {
    auto done = stream.erased<void(error_code)>(std::forward<Handler>(handler));
    if (stream.isEncrypted()) {
      // a peer that says no farewell is not waited for
      stream.next_layer().expires_after(kFarewell);
      stream.tls().async_shutdown(std::move(done));
    } else {
      boost::beast::async_teardown(role, stream.next_layer(), std::move(done));
    }
  }

 private:
  static constexpr std::size_t kMostBuffers = 8;
  static constexpr std::chrono::seconds kFarewell{2};

  /// A handler without its type, which runs where it would have run.
  template <typename Signature, typename Handler>
  [[nodiscard]] auto erased(Handler&& handler) {
    executor_type executor = boost::asio::get_associated_executor(handler, get_executor());
    return boost::asio::bind_executor(executor,
                                      boost::asio::any_completion_handler<Signature>(std::forward<Handler>(handler)));
  }

  /// Begins to read or write the first buffers that are not empty. Those that remain have no size.
  template <typename Buffer, typename Buffers, typename Token, typename Begin>
  auto start(const Buffers& buffers, Token&& token, Begin begin) {
    return boost::asio::async_initiate<Token, void(error_code, std::size_t)>(
        [this, begin](auto handler, const Buffers& all) {
          std::array<Buffer, kMostBuffers> few;
          std::size_t count = 0;
          for (auto at = boost::asio::buffer_sequence_begin(all);
               at != boost::asio::buffer_sequence_end(all) && count < kMostBuffers; ++at) {
            few[count] = Buffer(*at);
            count += few[count].size() > 0 ? 1 : 0;
          }
          begin(few, this->erased<void(error_code, std::size_t)>(std::move(handler)));
        },
        token, buffers);
  }

  std::variant<Tcp, Tls> stream_;
};

}  // namespace espalier::server

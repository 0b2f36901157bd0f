#pragma once

#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/ssl.hpp>

#include "server/network/peer_connection.h"
#include "server/remote/freed_memory.h"

namespace espalier::server {

/// Messages as lines and raw bytes over a stream of bytes: TCP, a Unix socket, or TLS over TCP. Only for the files that
/// know the network library.
template <typename Stream>
class StreamConnection final : public PeerConnection {
 public:
  StreamConnection(Stream stream, ServerCore& core, Accepted accepted)
      : PeerConnection(stream.get_executor(), core, std::move(accepted)),
        stream_(std::move(stream)),
        socket_(lowest().native_handle()),
        reader_(frameLimits()) {}

 protected:
  asio::awaitable<bool> prepare() override {
    if constexpr (kIsEncrypted) {
      const auto [error] = co_await stream_.async_handshake(asio::ssl::stream_base::server, kAsTuple);
      co_return !error;
    }
    co_return true;
  }

  asio::awaitable<bool> receive() override {
    const auto [error, count] = co_await stream_.async_read_some(asio::buffer(bytes_.get(), room_), kAsTuple);
    if (error == asio::error::eof) {
      noteEnd();
    }
    if (error) {
      co_return false;
    }
    PeerConnection::count(count);
    if (!isReading()) {
      co_return true;
    }
    reader_.feed({bytes_.get(), count});
    const std::size_t held = reader_.heldBytes();
    beginTurn();
    while (isReading() && !reader_.lost()) {
      const std::size_t bytes = reader_.nextLineBytes();
      if (bytes > kBigMessage) {
        co_await handOnWorker([this](std::optional<protocol::Error>&) { return reader_.next(); });
        continue;
      }
      const auto read = reader_.next();
      if (!read) {
        break;
      }
      hand(*read, bytes, reader_.hasPartialMessage());
      adoptTerms();
      if (isTurnOver()) {
        co_await giveWay();
      }
    }
    if (reader_.lost()) {
      lose(*reader_.lost());
    }
    reader_.rest();
    noteFreed(held - std::min(held, reader_.heldBytes()));
    setRoom(reader_.hasPartialMessage() && count >= kIdleRoom ? kMostRoom : kIdleRoom);
    if (!hold(reader_.heldBytes() + room_ - kIdleRoom)) {
      reader_ = protocol::MessageReader(frameLimits());
      setRoom(kIdleRoom);
    }
    co_return true;
  }

  asio::awaitable<bool> write(const Batch& messages) override {
    buffers_.clear();
    for (const auto& message : messages) {
      buffers_.push_back(asio::buffer(*message));
    }
    const auto [error, count] = co_await asio::async_write(stream_, buffers_, kAsTuple);
    // a list of very many short messages is not kept
    if (buffers_.capacity() > kIdleBuffers) {
      buffers_ = {};
    }
    co_return !error;
  }

  std::size_t writeNow(const std::string& message) override {
    if constexpr (kIsEncrypted) {
      return 0;
    } else {
      // not by Asio, whose sockets belong to one thread; what is wrong with the connection is met by write()
      const ssize_t bytes = ::send(socket_, message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      return bytes < 0 ? 0 : static_cast<std::size_t>(bytes);
    }
  }

  void shutdownSend() override {
    error_code ignored;
    lowest().shutdown(asio::socket_base::shutdown_send, ignored);
  }
  void closeTransport() override {
    error_code ignored;
    lowest().shutdown(asio::socket_base::shutdown_both, ignored);
    lowest().close(ignored);
  }

 private:
  static constexpr std::size_t kIdleBuffers = 1'000;
  // what one read may bring: little from a silent peer, of which there may be thousands, and much of a long message
  static constexpr std::size_t kIdleRoom = 16'384;
  static constexpr std::size_t kMostRoom = 262'144;
  static constexpr bool kIsEncrypted = requires(Stream & stream) { stream.next_layer(); };

  /// After hello the peer may send more.
  void adoptTerms() {
    if (isGreeted()) {
      reader_.setLineBytes(frameLimits().lineBytes);
    }
    if (areBlocksAgreed()) {
      reader_.allowBlocks();
    }
  }

  /// Makes room for what the next read may bring.
  void setRoom(std::size_t bytes) {
    if (bytes != room_) {
      bytes_ = std::make_unique_for_overwrite<char[]>(bytes);
      room_ = bytes;
    }
  }

  auto& lowest() { return stream_.lowest_layer(); }

  Stream stream_;
  const int socket_;  // of stream_, until that is closed
  protocol::MessageReader reader_;
  std::size_t room_ = kIdleRoom;  // of bytes_
  std::unique_ptr<char[]> bytes_ = std::make_unique_for_overwrite<char[]>(kIdleRoom);
  std::vector<asio::const_buffer> buffers_;
};

}  // namespace espalier::server

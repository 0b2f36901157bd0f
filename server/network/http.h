#pragma once

#include <boost/asio/ssl.hpp>
#include <functional>

#include "server/network/peer_connection.h"

namespace espalier::server {

// For the files that know the network library only.

/// What the HTTP side needs of the network.
struct HttpServices {
  ServerCore* core = nullptr;
  /// Gives a session to a connection and keeps it.
  std::function<void(std::shared_ptr<PeerConnection>)> admit;
};

/// Serves requests of one connection until it ends or becomes a WebSocket: `/`, `/health`, `/metrics`, and the upgrade
/// at `/espalier/1`.
asio::awaitable<void> serveHttp(asio::ip::tcp::socket socket, HttpServices services);
/// The same over TLS.
asio::awaitable<void> serveHttps(asio::ssl::stream<asio::ip::tcp::socket> stream, HttpServices services);

}  // namespace espalier::server

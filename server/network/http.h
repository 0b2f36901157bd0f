#pragma once

#include <boost/asio/ssl.hpp>
#include <functional>

#include "server/network/peer_connection.h"

namespace espalier::server {

// Only for the files that know the network library.

/// The parts of the network that the HTTP side needs.
struct HttpServices {
  ServerCore* core = nullptr;
  /// Gives a session to a connection and keeps it.
  std::function<void(std::shared_ptr<PeerConnection>)> admit;
};

/// Serves the requests of one connection until it ends or becomes a WebSocket: pages, downloads and the upgrade at
/// `/espalier/1`. TLS, the first request, the upgrade and hello have one deadline together.
/// With `encryption`, which outlives the connection, over TLS.
void serveHttp(asio::ip::tcp::socket socket, asio::ssl::context* encryption, Accepted accepted, HttpServices services);

}  // namespace espalier::server

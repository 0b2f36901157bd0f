#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace espalier::server {

class ServerCore;

/// An answer to a plain HTTP request.
struct HttpPage {
  unsigned status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
  std::string fileName{};  // to be saved under; empty: shown
};

/// The page of a target (path and query) of a GET or HEAD request.
[[nodiscard]] HttpPage pageOf(std::string_view target, const ServerCore& core);

/// Whether a page from `origin` may open a WebSocket: programs send none; a browser's must be of the host that it
/// connects to, or one of those allowed. `isLoopback`: the connection came in on this machine's own address, where a
/// host must be called so too (a foreign name that leads here is how pages reach what is meant for this machine only).
[[nodiscard]] bool isOriginAllowed(std::string_view origin, std::string_view host, bool isLoopback,
                                   const std::vector<std::string>& allowed);

/// Whether a request for a page with data may name this host: on a loopback address only names of this machine.
[[nodiscard]] bool isHostAllowed(std::string_view host, bool isLoopback);

}  // namespace espalier::server

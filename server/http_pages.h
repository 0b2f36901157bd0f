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
};

/// The page of a target (path and query) of a GET or HEAD request.
[[nodiscard]] HttpPage pageOf(std::string_view target, const ServerCore& core);

/// Whether a page from `origin` may open a WebSocket: programs send none; a browser's must be of the host that it
/// connects to, or one of those allowed.
[[nodiscard]] bool isOriginAllowed(std::string_view origin, std::string_view host,
                                   const std::vector<std::string>& allowed);

}  // namespace espalier::server

#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::server {

class ServerCore;
struct WebFile;

/// An answer to a plain HTTP request.
struct HttpPage {
  unsigned status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
  std::string fileName{};          // for saving; empty: the browser shows the page
  std::string policy{};            // Content-Security-Policy; empty: that of the server's own page
  std::shared_ptr<void> memory{};  // of the body, in an account; null: it is not counted
  const WebFile* file = nullptr;   // of the server's options: it is sent in place of `body`, and not copied
};

/// Whether a browser that sends this Accept-Encoding reads what gzip compressed.
[[nodiscard]] bool acceptsGzip(std::string_view encodings);

/// Whether a browser that sends this If-None-Match has the file of this tag.
[[nodiscard]] bool hasFile(std::string_view tags, std::string_view tag);

/// The page of a target (path and query) of a GET or HEAD request.
[[nodiscard]] HttpPage pageOf(std::string_view target, const ServerCore& core);

/// Whether a page from `origin` may open a WebSocket. Programs send no origin. The page of a browser must come from the
/// host that it connects to, or from one of the allowed origins. `isLoopback`: the connection came in on a loopback
/// address. Then the host must be a name of this machine too: a foreign name that leads here could come from any page.
[[nodiscard]] bool isOriginAllowed(std::string_view origin, std::string_view host, bool isLoopback,
                                   const std::vector<std::string>& allowed);

/// Whether a request for data may name this host. On a loopback address only names of this machine are allowed.
[[nodiscard]] bool isHostAllowed(std::string_view host, bool isLoopback);

}  // namespace espalier::server

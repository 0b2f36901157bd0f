#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/streams.h"
#include "server/language_server/run_counts.h"

namespace espalier::server {

class LanguageSession;

/// A server of the Language Server Protocol (3.17) for models and view files, with one editor. It does no input or
/// output: its owner hands it messages and sends what it gives back.
class LanguageServer {
 public:
  /// `files` gives the files that the editor has not open; it must outlive the object.
  explicit LanguageServer(core::FileProvider& files);
  ~LanguageServer();
  LanguageServer(LanguageServer&&) noexcept;

  /// Takes the JSON text of a message and returns the messages to be sent, in order. Text that is no JSON gets an
  /// error. `run` is asked for code lenses alone.
  [[nodiscard]] std::vector<std::string> receive(std::string_view message, const OpenRun& run = {});

  /// Whether the editor has said `exit`.
  [[nodiscard]] bool hasEnded() const;
  /// Whether it said `shutdown` before.
  [[nodiscard]] bool isShutDown() const;

 private:
  std::unique_ptr<LanguageSession> session_;
};

/// Cuts the bytes of a pipe into messages: a head with `Content-Length: N`, an empty line, N bytes.
class MessageCutter {
 public:
  static constexpr std::size_t kLongestMessage = std::size_t{64} << 20U;
  static constexpr std::size_t kLongestHead = 4096;

  void add(std::string_view bytes) { bytes_.append(bytes); }
  /// The next whole message; nothing: more bytes are needed.
  [[nodiscard]] std::optional<std::string> next();
  /// The head is no head of the protocol, or announces too much: nothing can be read any more.
  [[nodiscard]] bool isBroken() const { return isBroken_; }

 private:
  std::string bytes_;
  bool isBroken_ = false;
};

/// A message with its head.
[[nodiscard]] std::string framed(const std::string& message);

}  // namespace espalier::server

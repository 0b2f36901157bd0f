#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/streams.h"
#include "server/language_server/language_server.h"

namespace espalier::server {

/// A peer's conversation of the Language Server Protocol. Only the documents that the peer opens are read. Any thread;
/// one message at a time.
class EditorConversation {
 public:
  [[nodiscard]] std::vector<std::string> receive(const std::string& message) {
    const std::lock_guard lock(mutex_);
    return server_.receive(message);
  }

 private:
  class NoFiles final : public core::FileProvider {
   public:
    [[nodiscard]] std::optional<std::string> read(const std::string&) override { return std::nullopt; }
  };

  std::mutex mutex_;
  NoFiles files_;
  LanguageServer server_{files_};
};

}  // namespace espalier::server

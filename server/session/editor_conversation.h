#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/streams.h"
#include "server/language_server/language_server.h"
#include "server/running/account.h"

namespace espalier::server {

/// A peer's conversation of the Language Server Protocol. Only the documents that the peer opens are read. Its memory
/// counts for an account.
class EditorConversation : public std::enable_shared_from_this<EditorConversation> {
 public:
  /// A message is answered as long as this lives; then the next one has its turn.
  using Turn = std::shared_ptr<void>;
  using Messages = std::vector<std::string>;

  explicit EditorConversation(Account& account) : memory_(account, MemoryKind::Compiling) {}

  /// Calls `begin` when the turns before have ended: here, or at the end of the last of them on its thread. So messages
  /// that wait keep no worker. Thread-safe.
  void takeTurn(std::function<void(Turn)> begin);
  /// Hands the answers of a message to `answer`. `run`: LanguageServer::receive. In a turn only. Exceptions of `run`
  /// pass through, as does WorkStopped; the conversation goes on after that.
  void receive(const std::string& message, const OpenRun& run, const std::function<void(const Messages&)>& answer);

 private:
  class NoFiles final : public core::FileProvider {
   public:
    [[nodiscard]] std::optional<std::string> read(const std::string&) override { return std::nullopt; }
  };

  void beginNext();

  std::mutex mutex_;
  std::deque<std::function<void(Turn)>> waiting_;
  bool isBusy_ = false;
  std::int64_t keptBytes_ = 0;
  Holding memory_;
  NoFiles files_;
  LanguageServer server_{files_};
};

}  // namespace espalier::server

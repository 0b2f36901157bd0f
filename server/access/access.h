#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/roles.h"
#include "server/access/token.h"

namespace espalier::server {

/// The grant of a peer: its token and the roles.
struct Grant {
  std::shared_ptr<const Token> token;  // null: the server has no tokens
  protocol::Roles roles;
};

/// The tokens of a server. A server without tokens grants every role: it listens on this machine only. Thread-safe.
class Access {
 public:
  explicit Access(std::vector<Token> tokens);

  [[nodiscard]] bool hasTokens() const;
  /// The roles that the peer with this token gets of those that it asks for. No roles: all that the token has.
  /// Otherwise an error sentence. The duration does not depend on how much of the token is right.
  [[nodiscard]] tl::expected<Grant, std::string> grant(std::string_view token,
                                                       const std::vector<std::string>& roles) const;
  /// Why a grant does not hold any more, or nothing: the token has expired, or the operator took it away.
  [[nodiscard]] std::optional<std::string> problemOf(const Grant& grant) const;
  /// Other tokens from now on. False, and nothing changes, when all would be gone: the server would be open.
  [[nodiscard]] bool replace(std::vector<Token> tokens);

 private:
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<const Token>> tokens_;
};

}  // namespace espalier::server

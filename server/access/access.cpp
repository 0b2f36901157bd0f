#include "server/access/access.h"

#include <openssl/crypto.h>

#include <algorithm>

namespace espalier::server {
namespace {

std::vector<std::shared_ptr<const Token>> shared(std::vector<Token> tokens) {
  std::vector<std::shared_ptr<const Token>> result;
  for (Token& token : tokens) {
    result.push_back(std::make_shared<const Token>(std::move(token)));
  }
  return result;
}

bool isSame(const TokenHash& one, const TokenHash& other) {
  return ::CRYPTO_memcmp(one.data(), other.data(), one.size()) == 0;
}

std::string expired(const Token& token) {
  return "The token '" + token.name + "' expired at " + toText(*token.expires) +
         ". Ask the operator of the server for a new one.";
}

}  // namespace

Access::Access(std::vector<Token> tokens) : tokens_(shared(std::move(tokens))) {}

bool Access::hasTokens() const {
  const std::lock_guard lock(mutex_);
  return !tokens_.empty();
}

tl::expected<Grant, std::string> Access::grant(std::string_view token, const std::vector<std::string>& roles) const {
  Grant grant;
  protocol::Roles all;
  const TokenHash hash = hashOfToken(token);
  {
    const std::lock_guard lock(mutex_);
    for (const auto& known : tokens_) {
      if (isSame(known->hash, hash)) {
        grant.token = known;
      }
    }
    if (tokens_.empty()) {
      all = {protocol::Role::Controller};
    } else if (grant.token == nullptr) {
      return tl::unexpected(std::string(
          token.empty()
              ? "This server asks for a token (params.token of hello), and none came. Its operator has one."
              : "The server does not know this token. It is mistyped, was taken away, or is of an earlier start "
                "of the server: use the token, or the link, that the server has now."));
    } else {
      all = grant.token->roles;
    }
  }
  if (grant.token != nullptr && grant.token->isExpired(std::chrono::system_clock::now())) {
    return tl::unexpected(expired(*grant.token));
  }
  grant.roles = all.granted(roles);
  if (grant.roles.isEmpty()) {
    return tl::unexpected(
        "The token '" + grant.token->name + "' has the roles " + all.text() +
        ", and this program asks for others. Use another token; or let the program ask for one of these "
        "roles in params.roles of hello.");
  }
  return grant;
}

std::optional<std::string> Access::problemOf(const Grant& grant) const {
  if (grant.token == nullptr) {
    // tokens that an operator adds to an open server hold for its present users, too
    return hasTokens() ? std::optional<std::string>("The server asks for a token now. Connect again with one.")
                       : std::nullopt;
  }
  if (grant.token->isExpired(std::chrono::system_clock::now())) {
    return expired(*grant.token);
  }
  const std::lock_guard lock(mutex_);
  const bool isThere = std::any_of(tokens_.begin(), tokens_.end(), [&grant](const auto& known) {
    return known == grant.token || (known->name == grant.token->name && isSame(known->hash, grant.token->hash) &&
                                    known->roles == grant.token->roles && known->expires == grant.token->expires);
  });
  return isThere ? std::nullopt
                 : std::optional("The operator has changed or removed the token '" + grant.token->name +
                                 "'. Connect again with a token of the server.");
}

bool Access::replace(std::vector<Token> tokens) {
  auto fresh = shared(std::move(tokens));
  const std::lock_guard lock(mutex_);
  if (fresh.empty() && !tokens_.empty()) {
    return false;
  }
  tokens_ = std::move(fresh);
  return true;
}

}  // namespace espalier::server

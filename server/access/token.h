#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "protocol/roles.h"

namespace espalier::server {

using TokenHash = std::array<std::uint8_t, 32>;  // SHA-256 of the token's text
using WallTime = std::chrono::system_clock::time_point;

/// A token that clients may send. The server keeps its hash only.
struct Token {
  std::string name;  // for the log
  TokenHash hash{};
  protocol::Roles roles;
  std::optional<WallTime> expires;  // nothing: never

  [[nodiscard]] bool isExpired(WallTime now) const { return expires && now >= *expires; }
};

/// The token that has this text.
[[nodiscard]] Token tokenOf(std::string name, std::string_view text, protocol::Roles roles);
[[nodiscard]] TokenHash hashOfToken(std::string_view text);

/// A new text with 256 random bits.
[[nodiscard]] std::string drawTokenText();

/// Reads a line of the section [tokens]: the roles with commas between them, `sha256:` and 64 hexadecimal digits, and
/// perhaps `expires:` with a day or a time in UTC. An error sentence when something is wrong.
///
///     alice = "controller sha256:9f86d081… expires:2027-01-31"
[[nodiscard]] tl::expected<Token, std::string> readToken(const std::string& name, const std::string& line);
/// The line that readToken() reads.
[[nodiscard]] std::string toText(const Token& token);

/// `2027-01-31` or `2027-01-31T12:00:00Z`; nothing for any other text.
[[nodiscard]] std::optional<WallTime> readTime(const std::string& text);
[[nodiscard]] std::string toText(WallTime time);

}  // namespace espalier::server

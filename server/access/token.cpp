#include "server/access/token.h"

#include <openssl/rand.h>
#include <openssl/sha.h>
#include <time.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace espalier::server {
namespace {

constexpr std::string_view kHash = "sha256:";
constexpr std::string_view kExpires = "expires:";
// people see what it is when they find one
constexpr std::string_view kPrefix = "espalier_";

template <typename Bytes>
std::string hexOf(const Bytes& bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text;
}

std::optional<TokenHash> hashOfHex(std::string_view text) {
  TokenHash hash{};
  if (text.size() != 2 * hash.size()) {
    return std::nullopt;
  }
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t digit = std::string_view("0123456789abcdef").find(text[i]);
    if (digit == std::string_view::npos) {
      return std::nullopt;
    }
    hash[i / 2] = static_cast<std::uint8_t>(static_cast<unsigned>(hash[i / 2]) << 4U | static_cast<unsigned>(digit));
  }
  return hash;
}

bool isTokenName(std::string_view name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

/// The roles of a list with commas; nothing when one is unknown.
std::optional<protocol::Roles> rolesOf(std::string_view list) {
  protocol::Roles roles;
  while (true) {
    const std::size_t comma = std::min(list.find(','), list.size());
    const auto role = protocol::roleOf(list.substr(0, comma));
    if (!role) {
      return std::nullopt;
    }
    roles.add(*role);
    if (comma == list.size()) {
      return roles;
    }
    list.remove_prefix(comma + 1);
  }
}

}  // namespace

TokenHash hashOfToken(std::string_view text) {
  TokenHash hash{};
  ::SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), hash.data());
  return hash;
}

Token tokenOf(std::string name, std::string_view text, protocol::Roles roles) {
  return {std::move(name), hashOfToken(text), roles, std::nullopt};
}

std::string drawTokenText() {
  std::array<std::uint8_t, 32> bytes{};
  if (::RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    throw std::runtime_error("the system gives no random numbers");
  }
  return std::string(kPrefix) + hexOf(bytes);
}

tl::expected<Token, std::string> readToken(const std::string& name, const std::string& line) {
  const std::string where = "the token '" + name + "' of [tokens] ";
  if (!isTokenName(name)) {
    return tl::unexpected(where + "has an unusual name: use letters, digits, '-' and '_', at most 64.");
  }
  Token token;
  token.name = name;
  bool hasHash = false;
  std::istringstream words(line);
  for (std::string word; words >> word;) {
    if (word.starts_with(kHash)) {
      const auto hash = hashOfHex(std::string_view(word).substr(kHash.size()));
      if (!hash || hasHash) {
        return tl::unexpected(
            where + "needs one sha256: with 64 digits 0-9a-f behind it. 'espalier token new' writes the line.");
      }
      token.hash = *hash;
      hasHash = true;
    } else if (word.starts_with(kExpires)) {
      token.expires = readTime(word.substr(kExpires.size()));
      if (!token.expires) {
        return tl::unexpected(where + "has '" + word +
                              "', which is no time: write expires:2027-01-31 or expires:2027-01-31T12:00:00Z.");
      }
    } else if (const auto roles = rolesOf(word); roles && token.roles.isEmpty()) {
      token.roles = *roles;
    } else {
      return tl::unexpected(where + "has '" + word +
                            "', which is neither a list of roles (controller,viewer,environment) nor sha256: nor "
                            "expires:. 'espalier token new' writes the line.");
    }
  }
  if (token.roles.isEmpty() || !hasHash) {
    return tl::unexpected(where + "needs its roles and sha256:. 'espalier token new' writes the line.");
  }
  return token;
}

std::string toText(const Token& token) {
  std::string line;
  for (const std::string& role : token.roles.names()) {
    line += (line.empty() ? "" : ",") + role;
  }
  line += " " + std::string(kHash) + hexOf(token.hash);
  return token.expires ? line + " " + std::string(kExpires) + toText(*token.expires) : line;
}

std::optional<WallTime> readTime(const std::string& text) {
  for (const char* const form : {"%Y-%m-%d", "%Y-%m-%dT%H:%M:%SZ"}) {
    std::tm parts{};
    const char* const end = ::strptime(text.c_str(), form, &parts);
    if (end == nullptr || *end != '\0') {
      continue;
    }
    const WallTime time = std::chrono::system_clock::from_time_t(::timegm(&parts));
    // a day such as 2027-02-31 comes back as another one
    if (toText(time).starts_with(text.substr(0, 10))) {
      return time;
    }
  }
  return std::nullopt;
}

std::string toText(WallTime time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  std::array<char, 40> text{};
  const std::size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return {text.data(), length};
}

}  // namespace espalier::server

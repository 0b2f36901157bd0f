#include "server/language_server/language_server.h"

#include <algorithm>
#include <charconv>

#include "engine/core/work_meter.h"
#include "server/language_server/language_session.h"

namespace espalier::server {
namespace {

constexpr int kParseError = -32700;
constexpr std::string_view kHeadEnd = "\r\n\r\n";
constexpr std::string_view kLengthField = "content-length:";

// the number of the field Content-Length; nothing when there is none
std::optional<std::size_t> announcedLength(std::string_view head) {
  while (!head.empty()) {
    const std::size_t end = std::min(head.find("\r\n"), head.size());
    std::string_view line = head.substr(0, end);
    head.remove_prefix(std::min(end + 2, head.size()));
    const bool isLength = line.size() > kLengthField.size() &&
                          std::equal(kLengthField.begin(), kLengthField.end(), line.begin(), [](char wanted, char c) {
                            return wanted == (c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c);
                          });
    if (!isLength) {
      continue;
    }
    line.remove_prefix(kLengthField.size());
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    std::size_t length = 0;
    const auto read = std::from_chars(line.data(), line.data() + line.size(), length);
    if (read.ec == std::errc{} && read.ptr == line.data() + line.size()) {
      return length;
    }
    return std::nullopt;
  }
  return std::nullopt;
}

// bytes that are no UTF-8, as in an old model's comment, become U+FFFD
std::string messageText(const nlohmann::json& message) {
  return message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Members of messages lie a dozen deep. The library copies, compares and writes by recursion, so a deep value would
/// overflow the stack.
constexpr std::size_t kGreatestDepth = 100;

bool isNestedTooDeeply(std::string_view json) {
  std::size_t depth = 0;
  bool isInText = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (isInText && c == '\\') {
      ++i;
    } else if (c == '"') {
      isInText = !isInText;
    } else if (!isInText && (c == '[' || c == '{') && ++depth > kGreatestDepth) {
      return true;
    } else if (!isInText && (c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return false;
}

std::string errorWithoutId(int code, const std::string& message) {
  const nlohmann::json error{{"jsonrpc", "2.0"}, {"id", nullptr}, {"error", {{"code", code}, {"message", message}}}};
  return messageText(error);
}

}  // namespace

LanguageServer::LanguageServer(core::FileProvider& files) : session_(std::make_unique<LanguageSession>(files)) {}
LanguageServer::~LanguageServer() = default;
LanguageServer::LanguageServer(LanguageServer&&) noexcept = default;

std::vector<std::string> LanguageServer::receive(std::string_view message, const OpenRun& run) {
  core::pollWork();
  if (isNestedTooDeeply(message)) {
    return {errorWithoutId(kParseError, "the message is nested more than " + std::to_string(kGreatestDepth) +
                                            " deep: no message of the protocol is")};
  }
  const nlohmann::json parsed = nlohmann::json::parse(message, nullptr, false);
  if (parsed.is_discarded()) {
    return {errorWithoutId(kParseError, "the message is no JSON")};
  }
  std::vector<std::string> sent;
  for (const nlohmann::json& answer : session_->receive(parsed, run)) {
    sent.push_back(messageText(answer));
  }
  return sent;
}

bool LanguageServer::hasEnded() const {
  return session_->hasEnded();
}

bool LanguageServer::isShutDown() const {
  return session_->isShutDown();
}

std::optional<std::string> MessageCutter::next() {
  const std::size_t headEnd = bytes_.find(kHeadEnd);
  if (headEnd == std::string::npos) {
    isBroken_ = isBroken_ || bytes_.size() > kLongestHead;
    return std::nullopt;
  }
  const std::optional<std::size_t> length = announcedLength(std::string_view(bytes_).substr(0, headEnd));
  if (isBroken_ || !length || *length > kLongestMessage) {
    isBroken_ = true;
    return std::nullopt;
  }
  const std::size_t begin = headEnd + kHeadEnd.size();
  if (bytes_.size() - begin < *length) {
    return std::nullopt;
  }
  std::string message = bytes_.substr(begin, *length);
  bytes_.erase(0, begin + *length);
  return message;
}

std::string framed(const std::string& message) {
  return "Content-Length: " + std::to_string(message.size()) + std::string(kHeadEnd) + message;
}

}  // namespace espalier::server

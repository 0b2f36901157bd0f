#include "clients/cpp/conversation.h"

#include <algorithm>

#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "protocol/version.h"

namespace espalier::client {

using protocol::Error;
using protocol::ErrorCode;

protocol::Expected<Address> parseAddress(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size()) {
    return tl::unexpected(Error{ErrorCode::InvalidParams,
                                "'" + address + "' is not an address; write HOST:PORT, for example 127.0.0.1:4321.",
                                {}});
  }
  std::string host = address.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  return Address{std::move(host), address.substr(colon + 1)};
}

Error notReached(const std::string& address, const std::string& reason) {
  return {
      ErrorCode::Internal,
      "Cannot connect to " + address + ": " + reason + ". Start the server (espalier serve) or correct the address.",
      {}};
}

Error lostConnection(const std::string& reason) {
  return {ErrorCode::Internal, "The connection to the server is lost: " + reason + ". Connect again.", {}};
}

Error lateAnswer(std::string_view what, std::chrono::milliseconds timeout) {
  return {ErrorCode::Timeout,
          "No answer to " + std::string(what) + " within " + std::to_string(timeout.count()) + " ms.",
          {}};
}

std::string Conversation::helloJson() const {
  return protocol::encode(protocol::HelloParams{
      .protocol = {protocol::kProtocolVersion},
      .roles = options_.roles,
      .name = options_.name,
      .version = options_.version,
      .capabilities = options_.capabilities,
      .token = options_.token,
      .limits = {{"lineBytes", options_.limits.lineBytes}, {"blockBytes", options_.limits.blockBytes}}});
}

void Conversation::agree(std::string helloResult) {
  helloResult_ = std::move(helloResult);
  const auto capabilities = protocol::memberOf(helloResult_, "capabilities");
  const auto& own = options_.capabilities;
  if (capabilities && capabilities->find("\"bin\"") != std::string::npos &&
      std::find(own.begin(), own.end(), "bin") != own.end()) {
    reader_.allowBlocks();
  }
}

bool Conversation::takeMessage() {
  auto read = reader_.next();
  if (!read) {
    return false;
  }
  // a line that is no message is skipped: it answers nothing
  if (!*read) {
    return true;
  }
  protocol::Message* const message = &**read;
  using Kind = protocol::Message::Kind;
  switch (message->kind) {
    case Kind::Notification:
      notifications_.push_back({std::move(message->method), message->payload.toText(), message->payload});
      break;
    case Kind::Request:
      requests_.push_back({std::move(message->id), std::move(message->method), std::move(message->payload)});
      break;
    case Kind::Result:
    case Kind::Error:
      if (message->kind == Kind::Error && message->id.kind != protocol::MessageId::Kind::Number) {
        refusal_ = std::move(message->error);
      } else if (forgotten_.erase(message->id.number) == 0) {
        answers_.insert_or_assign(message->id.number, message->kind == Kind::Result
                                                          ? Outcome(message->payload.toText())
                                                          : Outcome(tl::unexpected(std::move(message->error))));
      }
      break;
  }
  return true;
}

std::optional<std::string> Conversation::broken() const {
  if (!reader_.lost()) {
    return std::nullopt;
  }
  return "the server sent a message that cannot be read: " + reader_.lost()->message;
}

std::optional<Outcome> Conversation::takeAnswer(std::int64_t id) {
  const auto found = answers_.find(id);
  if (found == answers_.end()) {
    return std::nullopt;
  }
  Outcome outcome = std::move(found->second);
  answers_.erase(found);
  return outcome;
}

namespace {

template <typename Item>
std::optional<Item> takeFirst(std::deque<Item>& queue) {
  if (queue.empty()) {
    return std::nullopt;
  }
  Item first = std::move(queue.front());
  queue.pop_front();
  return first;
}

}  // namespace

std::optional<Notification> Conversation::takeNotification() {
  return takeFirst(notifications_);
}

std::optional<IncomingRequest> Conversation::takeRequest() {
  return takeFirst(requests_);
}

}  // namespace espalier::client

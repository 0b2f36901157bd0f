#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "protocol/errors.h"

namespace espalier::protocol {

struct JsonTree;  // a parsed value; defined in json_tree.h, for protocol's own .cpp files only

/// The id of a request and of its answer.
struct MessageId {
  enum class Kind : std::uint8_t { Null, Number, Text };
  Kind kind = Kind::Null;
  std::int64_t number = 0;  // within ±2^53
  std::string text;

  bool operator==(const MessageId&) const = default;
  [[nodiscard]] static MessageId of(std::int64_t number) { return {Kind::Number, number, {}}; }
  [[nodiscard]] static MessageId of(std::string text) { return {Kind::Text, 0, std::move(text)}; }
};

/// The id as JSON, also for logs.
[[nodiscard]] std::string toText(const MessageId& id);

/// The params of a request or notification, or the result of a response. Cheap to copy; never changes.
class Payload {
 public:
  Payload() = default;
  Payload(std::shared_ptr<const JsonTree> root, const void* value, std::string name)
      : root_(std::move(root)), value_(value), name_(std::move(name)) {}

  [[nodiscard]] bool isPresent() const { return value_ != nullptr; }
  /// "params" or "result": the first part of the paths in errors.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// The value as compact JSON; "null" when absent.
  [[nodiscard]] std::string toText() const;
  /// The parsed value, for protocol's decoders.
  [[nodiscard]] const void* value() const { return value_; }

 private:
  std::shared_ptr<const JsonTree> root_;
  const void* value_ = nullptr;
  std::string name_ = "params";
};

/// One message of the wire.
struct Message {
  enum class Kind : std::uint8_t { Request, Notification, Result, Error };
  Kind kind = Kind::Notification;
  MessageId id;        // Null for notifications; an error may answer a request whose id could not be read
  std::string method;  // requests and notifications
  Payload payload;     // params or result
  Error error;         // Kind::Error
};

/// Why a line is not a message. To be answered with `id` (Null when it could not be read) and `error`.
struct BadMessage {
  MessageId id;
  Error error;
};

/// Reads one line. Strict: an object, JSON-RPC "2.0", an id that is a whole number within ±2^53 or a text of at most
/// 200 bytes, params an object, nesting at most 64. Unknown fields are ignored.
[[nodiscard]] std::variant<Message, BadMessage> decodeMessage(std::string_view line);

/// Each returns one line with its `\n`. The json arguments are compact JSON texts.
[[nodiscard]] std::string encodeRequest(const MessageId& id, std::string_view method, std::string_view paramsJson);
[[nodiscard]] std::string encodeNotification(std::string_view method, std::string_view paramsJson);
[[nodiscard]] std::string encodeResult(const MessageId& id, std::string_view resultJson);
[[nodiscard]] std::string encodeError(const MessageId& id, const Error& error);

/// One member of a JSON object given as text, for small programs: the text of a string, or the compact JSON of anything
/// else; nothing when the text is not an object or has no such member.
[[nodiscard]] std::optional<std::string> memberOf(std::string_view json, std::string_view name);

/// The member `name` of a JSON object given as text, when it is itself an object whose members are all texts; nothing
/// otherwise.
[[nodiscard]] std::optional<std::map<std::string, std::string>> textsOf(std::string_view json, std::string_view name);

/// What is wrong with a text that should be one JSON value, or nothing. `line 3, column 7: ...`.
[[nodiscard]] std::optional<std::string> jsonProblem(std::string_view json);

}  // namespace espalier::protocol

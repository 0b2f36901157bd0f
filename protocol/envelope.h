#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "protocol/blocks.h"
#include "protocol/errors.h"

namespace espalier::protocol {

struct JsonTree;  // a parsed value; defined in json_tree.h, for protocol's own .cpp files only
struct BulkText;  // a message of many numbers; defined in bulk_text.h

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
  Payload(std::shared_ptr<const BulkText> bulk, std::string name) : bulk_(std::move(bulk)), name_(std::move(name)) {}

  [[nodiscard]] bool isPresent() const { return value_ != nullptr || bulk_ != nullptr; }
  /// "params" or "result": the first part of the paths in errors.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// The value as JSON; "null" when absent.
  [[nodiscard]] std::string toText() const;
  /// The parsed value, for protocol's decoders.
  [[nodiscard]] const void* value() const { return value_; }
  /// What the bulk reader read instead of a tree; null: there is a tree.
  [[nodiscard]] const BulkText* bulk() const { return bulk_.get(); }
  /// The binary blocks that came with the message; null: none.
  [[nodiscard]] const Blocks* blocks() const { return blocks_.get(); }
  void attach(std::shared_ptr<const Blocks> blocks) { blocks_ = std::move(blocks); }

 private:
  std::shared_ptr<const JsonTree> root_;
  std::shared_ptr<const BulkText> bulk_;
  std::shared_ptr<const Blocks> blocks_;
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
  std::vector<BlockDescription> blockTable;  // `bin`, checked; the bytes follow the line
  std::uint64_t blockBytes = 0;              // `binBytes`: raw bytes after the line
};

/// Why a line is not a message. To be answered with `id` (Null when it could not be read) and `error`.
struct BadMessage {
  MessageId id;
  Error error;
  std::uint64_t blockBytes = 0;  // raw bytes after the line, to be skipped
};

/// Reads one line. Strict: an object, JSON-RPC "2.0", an id that is a whole number within ±2^53 or a text of at most
/// 200 bytes, params an object, nesting at most 64. Unknown fields are ignored. The bytes of blocks are the caller's to
/// attach (framing.h does).
[[nodiscard]] std::variant<Message, BadMessage> decodeMessage(std::string_view line);

/// Each returns one line with its `\n`, and behind it the raw bytes of the blocks, if any. JSON texts are compact.
[[nodiscard]] std::string encodeRequest(const MessageId& id, std::string_view method, const Body& params);
[[nodiscard]] std::string encodeNotification(std::string_view method, const Body& params);
[[nodiscard]] std::string encodeResult(const MessageId& id, const Body& result);
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

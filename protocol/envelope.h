#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/blocks.h"
#include "protocol/errors.h"
#include "protocol/message_id.h"
#include "protocol/payload.h"

namespace espalier::protocol {

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

/// The reason why a line is not a message. The answer has `id` (Null when it could not be read) and `error`.
struct BadMessage {
  MessageId id;
  Error error;
  std::uint64_t blockBytes = 0;  // raw bytes after the line, to be skipped
};

/// Reads one line. Strict: an object, JSON-RPC "2.0", an id that is a whole number within ±2^53 or a text of at most
/// 200 bytes, params an object, nesting at most 64. Unknown members are ignored. The bytes of blocks are the caller's
/// to attach (framing.h does).
[[nodiscard]] tl::expected<Message, BadMessage> decodeMessage(std::string_view line);

/// Each returns one line with its `\n`, and behind it the raw bytes of the blocks, if any. JSON texts are compact.
[[nodiscard]] std::string encodeRequest(const MessageId& id, std::string_view method, const Body& params);
[[nodiscard]] std::string encodeNotification(std::string_view method, const Body& params);
[[nodiscard]] std::string encodeResult(const MessageId& id, const Body& result);
[[nodiscard]] std::string encodeError(const MessageId& id, const Error& error);

}  // namespace espalier::protocol

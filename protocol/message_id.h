#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace espalier::protocol {

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

}  // namespace espalier::protocol

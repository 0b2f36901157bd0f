#include <algorithm>
#include <string>
#include <variant>

#include "engine/core/check.h"
#include "protocol/codec.h"
#include "protocol/framing.h"
#include "tests/fuzz/targets.h"

namespace espalier::fuzz {
namespace {

using namespace protocol;

constexpr std::size_t kQueries = 20;

/// The message that crosses as bytes; it was written by us and must be right.
Message crossed(const std::string& bytes) {
  MessageReader reader{FrameLimits{}};
  reader.allowBlocks();
  reader.feed(bytes);
  const auto read = reader.next();
  ESPALIER_CHECK(read.has_value() && std::holds_alternative<Message>(*read));
  return std::get<Message>(*read);
}

EnvironmentStepParams readBack(const Body& body) {
  const auto again =
      decodeEnvironmentStepParams(crossed(encodeRequest(MessageId::of(1), "environment.step", body)).payload);
  ESPALIER_CHECK(std::holds_alternative<EnvironmentStepParams>(again));
  return std::get<EnvironmentStepParams>(again);
}

/// What was read must be the same after it was written as text and in blocks. Text names the module of a query that
/// blocks without that column leave out, so it is the same from the second time on.
void checkStep(const EnvironmentStepParams& step) {
  const std::string text = encode(step);
  ESPALIER_CHECK(encode(readBack(encodeBlocks(step))) == text);
  const std::string whole = encode(readBack(Body(text)));
  ESPALIER_CHECK(encode(readBack(Body(whole))) == whole);
}

void checkReplies(const ReplyColumns& replies) {
  const std::string text = encode(replies);
  const Message message = crossed(encodeResult(MessageId::of(1), encodeBlocks(replies)));
  const auto again = decodeReplies(message.payload, kQueries);
  ESPALIER_CHECK(std::holds_alternative<ReplyColumns>(again));
  ESPALIER_CHECK(encode(std::get<ReplyColumns>(again)) == text);
}

/// Every decoder looks at it, whatever it is.
void decodeAll(const Message& message) {
  const Payload& payload = message.payload;
  (void)decodeHelloParams(payload);
  (void)decodeCreateParams(payload);
  (void)decodeStreamOpenParams(payload);
  (void)decodeOpenParams(payload);
  (void)decodeDescribeResult(payload);
  (void)decodeHelloResult(payload);
  (void)payload.toText();
  const auto step = decodeEnvironmentStepParams(payload);
  if (const auto* params = std::get_if<EnvironmentStepParams>(&step)) {
    checkStep(*params);
  }
  const auto replies = decodeReplies(payload, kQueries);
  if (const auto* columns = std::get_if<ReplyColumns>(&replies)) {
    checkReplies(*columns);
  }
}

/// What the fast reader takes, the tree takes too, and reads the same.
void checkBulk(std::string_view line) {
  BulkTextReader reader;
  const auto fast = reader.read(line);
  if (!fast) {
    return;
  }
  const auto tree = decodeMessage(line);
  ESPALIER_CHECK(std::holds_alternative<Message>(tree));
  const Message& slow = std::get<Message>(tree);
  ESPALIER_CHECK(fast->id == slow.id && fast->method == slow.method && fast->kind == slow.kind);
  const auto a = decodeEnvironmentStepParams(fast->payload);
  const auto b = decodeEnvironmentStepParams(slow.payload);
  ESPALIER_CHECK(a.index() == b.index());
  if (const auto* params = std::get_if<EnvironmentStepParams>(&a)) {
    ESPALIER_CHECK(encode(*params) == encode(std::get<EnvironmentStepParams>(b)));
  }
  const auto c = decodeReplies(fast->payload, kQueries);
  const auto d = decodeReplies(slow.payload, kQueries);
  ESPALIER_CHECK(c.index() == d.index());
  if (const auto* columns = std::get_if<ReplyColumns>(&c)) {
    ESPALIER_CHECK(encode(*columns) == encode(std::get<ReplyColumns>(d)));
  }
}

}  // namespace

void fuzzMessages(std::string_view bytes) {
  if (bytes.empty()) {
    return;
  }
  // the first byte says in what pieces the rest arrives
  const std::size_t piece = 1 + static_cast<unsigned char>(bytes[0]) % 64;
  const std::string_view rest = bytes.substr(1);
  MessageReader reader({.lineBytes = 20'000, .blockBytes = 20'000});
  reader.allowBlocks();
  for (std::size_t i = 0; i < rest.size(); i += piece) {
    reader.feed(rest.substr(i, piece));
    while (const auto read = reader.next()) {
      if (const auto* message = std::get_if<Message>(&*read)) {
        decodeAll(*message);
      }
    }
  }
  BulkTextReader bulk;
  std::optional<Error> problem;
  const auto frame = readFrame(rest, true, true, bulk, problem);
  ESPALIER_CHECK(frame.has_value() != problem.has_value());
  if (frame && std::holds_alternative<Message>(*frame)) {
    decodeAll(std::get<Message>(*frame));
  }
  checkBulk(rest.substr(0, rest.find('\n')));
}

}  // namespace espalier::fuzz

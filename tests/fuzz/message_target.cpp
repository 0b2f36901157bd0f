#include <algorithm>
#include <string>

#include "engine/core/check.h"
#include "protocol/codec.h"
#include "protocol/framing.h"
#include "protocol/methods.h"
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
  ESPALIER_CHECK(read.has_value() && read->has_value());
  return read->value();
}

EnvironmentStepParams readBack(const Body& body) {
  const auto again =
      decodeEnvironmentStepParams(crossed(encodeRequest(MessageId::of(1), "environment.step", body)).payload);
  ESPALIER_CHECK(again.has_value());
  return again.value();
}

/// A step that was read must be the same after it was written as text and in blocks. Text names the module of a query
/// that blocks without that column leave out, so it is the same from the second time on.
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
  ESPALIER_CHECK(again.has_value());
  ESPALIER_CHECK(encode(again.value()) == text);
}

/// Every decoder looks at it, whatever it is.
void decodeAll(const Message& message) {
  const Payload& payload = message.payload;
  for (const Method& method : methods()) {
    if (method.problemOf != nullptr) {
      (void)method.problemOf(payload);
    }
  }
  (void)decodeDescribeResult(payload);
  (void)decodeHelloResult(payload);
  (void)payload.toText();
  const auto step = decodeEnvironmentStepParams(payload);
  if (step) {
    checkStep(*step);
  }
  const auto replies = decodeReplies(payload, kQueries);
  if (replies) {
    checkReplies(*replies);
  }
}

/// Every line that the fast reader takes, the tree takes too, and reads the same.
void checkBulk(std::string_view line) {
  BulkTextReader reader;
  const auto fast = reader.read(line);
  if (!fast) {
    return;
  }
  const auto tree = decodeMessage(line);
  ESPALIER_CHECK(tree.has_value());
  const Message& slow = tree.value();
  ESPALIER_CHECK(fast->id == slow.id && fast->method == slow.method && fast->kind == slow.kind);
  const auto a = decodeEnvironmentStepParams(fast->payload);
  const auto b = decodeEnvironmentStepParams(slow.payload);
  ESPALIER_CHECK(a.has_value() == b.has_value());
  if (a) {
    ESPALIER_CHECK(encode(*a) == encode(*b));
  }
  const auto c = decodeReplies(fast->payload, kQueries);
  const auto d = decodeReplies(slow.payload, kQueries);
  ESPALIER_CHECK(c.has_value() == d.has_value());
  if (c) {
    ESPALIER_CHECK(encode(*c) == encode(*d));
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
      if (*read) {
        decodeAll(**read);
      }
    }
  }
  BulkTextReader bulk;
  std::optional<Error> problem;
  const auto frame = readFrame(rest, true, true, bulk, problem);
  ESPALIER_CHECK(frame.has_value() != problem.has_value());
  if (frame && frame->has_value()) {
    decodeAll(frame->value());
  }
  checkBulk(rest.substr(0, rest.find('\n')));
}

}  // namespace espalier::fuzz

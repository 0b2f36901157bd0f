#include "protocol/envelope.h"
#include "protocol/json_text.h"

#include <gtest/gtest.h>

namespace espalier::protocol::envelope_test {
namespace {

Message good(std::string_view line) {
  auto decoded = decodeMessage(line);
  if (!decoded) {
    ADD_FAILURE() << decoded.error().error.message;
    return {};
  }
  return std::move(decoded.value());
}

BadMessage bad(std::string_view line) {
  auto decoded = decodeMessage(line);
  if (decoded.has_value()) {
    ADD_FAILURE() << "accepted: " << line;
    return {};
  }
  return std::move(decoded.error());
}

TEST(Envelope, TellsRequestsNotificationsResultsAndErrorsApart) {
  EXPECT_EQ(good(R"({"jsonrpc":"2.0","id":1,"method":"m","params":{}})").kind, Message::Kind::Request);
  EXPECT_EQ(good(R"({"jsonrpc":"2.0","method":"m"})").kind, Message::Kind::Notification);
  EXPECT_EQ(good(R"({"jsonrpc":"2.0","id":"s1","result":null})").kind, Message::Kind::Result);
  const Message error = good(R"({"jsonrpc":"2.0","id":null,"error":{"code":1010,"message":"x","data":{"a":1}}})");
  EXPECT_EQ(error.kind, Message::Kind::Error);
  EXPECT_EQ(error.error.code, ErrorCode::Cancelled);
  EXPECT_EQ(error.error.data, R"({"a":1})");
}

TEST(Envelope, KeepsIdsAsNumbersOrTexts) {
  EXPECT_EQ(good(R"({"jsonrpc":"2.0","id":9007199254740992,"method":"m"})").id, MessageId::of(9007199254740992));
  EXPECT_EQ(good(R"({"jsonrpc":"2.0","id":"1","method":"m"})").id, MessageId::of(std::string("1")));
  EXPECT_EQ(toText(MessageId::of(std::string("a\"b"))), R"("a\"b")");
}

TEST(Envelope, RefusesIdsThatNotEveryLanguageCanHold) {
  EXPECT_EQ(bad(R"({"jsonrpc":"2.0","id":9007199254740993,"method":"m"})").error.message,
            "id: an id beyond 2^53 is not exact in every language; use a smaller number or a text");
  EXPECT_EQ(bad(R"({"jsonrpc":"2.0","id":-9007199254740993,"method":"m"})").error.message,
            "id: an id beyond 2^53 is not exact in every language; use a smaller number or a text");
  EXPECT_EQ(bad(R"({"jsonrpc":"2.0","id":1.5,"method":"m"})").error.message,
            "id: expected a whole number or a text as id");
  EXPECT_EQ(bad(R"({"jsonrpc":"2.0","id":")" + std::string(201, 'x') + R"(","method":"m"})").error.code,
            ErrorCode::InvalidRequest);
}

TEST(Envelope, AnswersWhatIsWrongAfterTheIdWithTheId) {
  const BadMessage wrong = bad(R"({"jsonrpc":"2.0","id":7,"method":"m","params":[1]})");
  EXPECT_EQ(wrong.id, MessageId::of(7));
  EXPECT_EQ(wrong.error.message, "params: expected an object (params by name)");
  EXPECT_EQ(bad(R"({"id":7,"method":"m"})").error.message, "jsonrpc: expected \"2.0\"");
  EXPECT_EQ(bad(R"({"jsonrpc":"2.0","id":7})").error.code, ErrorCode::InvalidRequest);
  EXPECT_EQ(bad(R"({"jsonrpc":"2.0","id":7,"result":1,"error":{}})").error.code, ErrorCode::InvalidRequest);
}

TEST(Envelope, RefusesBatchesOtherValuesAndRubbish) {
  EXPECT_EQ(bad("[]").error.message, "Batch arrays are not part of espalier/1. Send one object per line.");
  EXPECT_EQ(bad("3").error.code, ErrorCode::InvalidRequest);
  EXPECT_EQ(bad("{\"a\":").error.code, ErrorCode::Parse);
  EXPECT_EQ(bad("{\"a\":NaN}").error.code, ErrorCode::Parse);
  EXPECT_EQ(bad("{\"a\":\"\xff\"}").error.code, ErrorCode::Parse);
  EXPECT_EQ(bad("{\"a\":1e999}").error.code, ErrorCode::Parse);
}

TEST(Envelope, RefusesDeepNestingWithoutRecursion) {
  const BadMessage deep = bad(std::string(5'000'000, '['));
  EXPECT_EQ(deep.error.message, "The message nests brackets deeper than 64. Send flatter JSON.");
  // brackets in texts do not count
  EXPECT_EQ(good(R"({"jsonrpc":"2.0","method":"m","params":{"a":")" + std::string(100, '[') + R"("}})").method, "m");
  // a quote behind a backslash ends no text, one behind two does
  const std::string many(100, '[');
  EXPECT_EQ(good(R"({"jsonrpc":"2.0","method":"m","params":{"a":"\")" + many + R"("}})").method, "m");
  EXPECT_EQ(bad(R"(["\"",)" + many).error.message, deep.error.message);
  EXPECT_EQ(bad(R"(["\\",)" + many).error.message, deep.error.message);
}

TEST(Envelope, RefusesNamesThatComeTwiceInAnObject) {
  const BadMessage twice = bad(R"({"jsonrpc":"2.0","id":1,"method":"m","params":{"a":[{"b":1,"c":2,"b":1}]}})");
  EXPECT_EQ(twice.error.code, ErrorCode::InvalidRequest);
  EXPECT_EQ(twice.error.message, "An object of the message has 'b' twice. Send each name once.");
  EXPECT_EQ(bad(R"({"jsonrpc":"2.0","id":1,"id":2,"method":"m"})").error.code, ErrorCode::InvalidRequest);
  // the same name in objects of their own is none
  EXPECT_EQ(good(R"({"jsonrpc":"2.0","method":"m","params":{"a":{"a":1},"b":[{"a":1},{"a":2}]}})").method, "m");
}

TEST(Envelope, WritesOneLineEach) {
  EXPECT_EQ(encodeRequest(MessageId::of(std::string("s1")), "m", "{}"),
            "{\"jsonrpc\":\"2.0\",\"id\":\"s1\",\"method\":\"m\",\"params\":{}}\n");
  EXPECT_EQ(encodeNotification("m", "{}"), "{\"jsonrpc\":\"2.0\",\"method\":\"m\",\"params\":{}}\n");
  EXPECT_EQ(encodeResult(MessageId::of(1), "{}"), "{\"jsonrpc\":\"2.0\",\"id\":1,\"result\":{}}\n");
  EXPECT_EQ(encodeError({}, {ErrorCode::Limit, "two\nlines", {}}),
            "{\"jsonrpc\":\"2.0\",\"id\":null,\"error\":{\"code\":1004,\"message\":\"two\\nlines\"}}\n");
}

TEST(Envelope, MemberOfReadsTextsAndJson) {
  EXPECT_EQ(memberOf(R"({"a":"x","b":[1, 2]})", "a"), "x");
  EXPECT_EQ(memberOf(R"({"a":"x","b":[1, 2]})", "b"), "[1,2]");
  EXPECT_EQ(memberOf(R"({"a":"x"})", "c"), std::nullopt);
  EXPECT_EQ(memberOf("rubbish", "c"), std::nullopt);
}

TEST(Envelope, ReadsAnObjectOfTexts) {
  const auto texts = textsOf(R"({"files":{"a.e":"x: 1\n","b":""}})", "files");
  ASSERT_TRUE(texts.has_value());
  EXPECT_EQ(*texts, (std::map<std::string, std::string>{{"a.e", "x: 1\n"}, {"b", ""}}));
  EXPECT_EQ(textsOf(R"({"files":{"a.e":1}})", "files"), std::nullopt);
  EXPECT_EQ(textsOf(R"({"files":"a"})", "files"), std::nullopt);
  EXPECT_EQ(textsOf(R"({})", "files"), std::nullopt);
  EXPECT_EQ(textsOf("rubbish", "files"), std::nullopt);
}

}  // namespace
}  // namespace espalier::protocol::envelope_test

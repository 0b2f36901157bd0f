#include "protocol/bulk_text.h"

#include <gtest/gtest.h>

#include <random>

#include "protocol/codec.h"
#include "protocol/framing.h"

namespace espalier::protocol::bulk_text_test {
namespace {

std::string stepLine(std::size_t count, const std::string& extra = "") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> real(-10.0, 10.0);
  JsonWriter writer;
  writer.beginObject().key("simulation").text("s").key("step").integer(std::uint64_t{3}).key("iteration");
  writer.integer(std::uint64_t{0}).key("time").number(1.5).key("queries").beginArray();
  for (std::size_t i = 0; i < count; ++i) {
    writer.beginObject().key("id").integer(std::uint64_t{i}).key("plant").integer(std::uint64_t{i % 3}).key("module");
    writer.integer(std::uint64_t{2 * i});
    if (i % 7 == 0) {
      writer.key("transient").boolean(true);
    }
    writer.key("symbol").text(i % 2 == 0 ? "E" : "\u00e9\"x").key("parameters").beginArray();
    for (std::size_t k = 0; k < i % 3; ++k) {
      writer.number(k == 1 ? -0.0 : real(random));
    }
    writer.endArray().key("position").beginArray().number(real(random)).number(1e-310).raw("-0").endArray();
    if (i % 5 == 0) {
      writer.key("scale").number(real(random));
      writer.key("following").beginObject().key("symbol").text("F").key("parameters").beginArray();
      writer.number(real(random)).endArray().endObject();
    }
    writer.endObject();
  }
  writer.endArray();
  return R"({"jsonrpc":"2.0","id":"s7","method":"environment.step","params":)" + writer.endObject().take() + extra +
         "}";
}

std::string replyLine(std::size_t count, const std::string& last) {
  std::string line = R"({"jsonrpc":"2.0","id":12,"result":{"replies":[)";
  for (std::size_t i = 0; i < count; ++i) {
    line += R"({"id":)" + std::to_string(count - i) + R"(,"parameters":[0.)" + std::to_string(i + 1) + ",null,-0]},";
  }
  return line + R"({"id":0,"parameters":[)" + last + "]}]}}";
}

TEST(BulkText, AStepReadsBitwiseAsTheTreeReadsIt) {
  const std::string line = stepLine(300);
  BulkTextReader reader;
  const auto message = reader.read(line);
  ASSERT_TRUE(message.has_value());
  const auto tree = decodeMessage(line).value();
  EXPECT_EQ(message->id, tree.id);
  EXPECT_EQ(message->method, tree.method);
  EXPECT_EQ(message->kind, tree.kind);
  const auto fast = decodeEnvironmentStepParams(message->payload).value();
  const auto slow = decodeEnvironmentStepParams(tree.payload).value();
  EXPECT_EQ(encode(fast), encode(slow));
  EXPECT_EQ(fast.queries.count, 300U);
  EXPECT_EQ(slow.simulation, "s");
  // the text is there for a caller that wants it
  EXPECT_EQ(message->payload.toText(),
            line.substr(line.find("{\"simulation"), line.size() - line.find("{\"simulation") - 1));
}

TEST(BulkText, RepliesReadBitwiseAsTheTreeReadsThem) {
  const std::string line = replyLine(400, "1.25");
  BulkTextReader reader;
  const auto message = reader.read(line);
  ASSERT_TRUE(message.has_value());
  const auto fast = decodeReplies(message->payload, 401).value();
  const auto slow = decodeReplies(decodeMessage(line).value().payload, 401).value();
  EXPECT_EQ(encode(fast), encode(slow));
  EXPECT_EQ(fast.count, 401U);
  // and notes
  const std::string noting = line.substr(0, line.rfind("}}")) + R"(,"notes":["it is \u00e9"]}})" + "\n";
  const auto noted = reader.read(noting);
  ASSERT_TRUE(noted.has_value());
  EXPECT_EQ(decodeReplies(noted->payload, 401).value().notes, std::vector<std::string>{"it is \u00e9"});
  // ids are checked as ever
  EXPECT_FALSE(decodeReplies(message->payload, 400).has_value());
}

TEST(BulkText, NumbersOfAnyLengthReadAsTheNearestDouble) {
  const std::vector<std::pair<std::string, double>> numbers{
      {"0.184467440737095516155", 0.184467440737095516155},
      {"0.30000000000000004440892098500626", 0.1 + 0.2},
      {"0.1000000000000000055511151231257827021181583404541015625", 0.1},
      {"-0.000000000000000000000000000000000000012345678901234567890123", -1.2345678901234567890123e-38},
      {"123456789012345678901234567890", 123456789012345678901234567890.0},
      {"1.7976931348623157081e308", 1.7976931348623157e308},
      {"4.9406564584124654417656879286822e-324", 4.9406564584124654e-324},
      {"18446744073709551615", 18446744073709551615.0},
      {"9007199254740993.0000000000000001", 9007199254740994.0},
  };
  for (const auto& [text, value] : numbers) {
    BulkTextReader reader;
    const std::string line = replyLine(3, text);
    const auto message = reader.read(line);
    const auto tree = decodeMessage(line).value();
    // a line that the fast reader leaves to the tree is right too
    const Payload& payload = message ? message->payload : tree.payload;
    EXPECT_EQ(decodeReplies(payload, 4).value().values.back(), value) << text;
    EXPECT_EQ(decodeReplies(tree.payload, 4).value().values.back(), value) << text;
  }
}

TEST(BulkText, WhatIsUnusualIsLeftToTheTree) {
  BulkTextReader reader;
  for (const char* last : {"NaN", "1e999", "\"x\"", "1]]", "01", "1,", "true", ""}) {
    const std::string line = replyLine(10, last);
    const bool isUnderstood = std::string(last).empty();
    EXPECT_EQ(reader.read(line).has_value(), isUnderstood) << last;
  }
  const std::string line = stepLine(10);
  EXPECT_TRUE(reader.read(line).has_value());
  EXPECT_FALSE(reader.read(line + "x").has_value());
  EXPECT_FALSE(reader.read(line.substr(0, line.size() - 1)).has_value());
  EXPECT_FALSE(reader.read(stepLine(10, R"(,"unknown":1)")).has_value());
  EXPECT_FALSE(reader.read(stepLine(10, R"(,"id":1)")).has_value());
  std::string other = line;
  other.replace(other.find("\"id\":5"), 6, "\"id\":6");
  EXPECT_FALSE(reader.read(other).has_value());
  // members that must be there
  for (const std::string_view member : {R"("simulation":"s",)", R"("step":3,)", R"("symbol":"E",)", R"("id":4,)"}) {
    std::string without = line;
    without.erase(without.find(member), member.size());
    EXPECT_FALSE(reader.read(without).has_value()) << member;
  }
}

TEST(BulkText, ABigAnswerToAnotherQuestionIsStillReadByItsOwnDecoder) {
  std::string line = replyLine(400, "1");
  MessageReader reader{FrameLimits{}};
  reader.feed(line + "\n");
  const auto read = reader.next();
  const auto& message = read->value();
  EXPECT_NE(message.payload.bulk(), nullptr);
  const auto description = decodeDescribeResult(message.payload);
  EXPECT_TRUE(description.has_value());
}

}  // namespace
}  // namespace espalier::protocol::bulk_text_test

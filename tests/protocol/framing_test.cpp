#include "protocol/framing.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace espalier::protocol::framing_test {
namespace {

TEST(Framing, CutsLinesHoweverTheBytesArrive) {
  LineSplitter splitter(100);
  std::string lines;
  for (const char byte : std::string("one\r\n\n\ntwo\nthree\n")) {
    splitter.feed({&byte, 1});
    for (auto line = splitter.next(); line.data() != nullptr; line = splitter.next()) {
      lines += std::string(line) + "|";
    }
  }
  EXPECT_EQ(lines, "one|two|three|");
  EXPECT_FALSE(splitter.hasPartialLine());
  splitter.feed("cut");
  EXPECT_EQ(splitter.next().data(), nullptr);
  EXPECT_TRUE(splitter.hasPartialLine());
}

TEST(Framing, ALineAtTheLimitPassesAndOneBeyondLosesTheFraming) {
  LineSplitter splitter(4);
  splitter.feed("1234\n12345\nok\n");
  EXPECT_EQ(splitter.next(), "1234");
  EXPECT_EQ(splitter.next().data(), nullptr);
  EXPECT_TRUE(splitter.isOverflowed());
  EXPECT_EQ(splitter.overflowBytes(), 5U);
  splitter.feed("ok\n");
  EXPECT_EQ(splitter.next().data(), nullptr);
}

TEST(Framing, AnEndlessLineIsNoticedBeforeItsEnd) {
  LineSplitter splitter(4);
  splitter.feed("12345");
  EXPECT_EQ(splitter.next().data(), nullptr);
  EXPECT_TRUE(splitter.isOverflowed());
}

Message messageOf(std::optional<MessageReader::Read> read) {
  EXPECT_TRUE(read.has_value());
  if (!*read) {
    ADD_FAILURE() << read->error().error.message;
    return {};
  }
  return std::move(*read).value();
}

/// A request with one block of `count` numbers, and another without.
std::string twoRequests(std::size_t count) {
  Body body("{}");
  std::vector<double> numbers(count);
  for (std::size_t i = 0; i < count; ++i) {
    numbers[i] = 0.1 * static_cast<double>(i);
  }
  body.blocks.keep("x", numbers, {count});
  body.blocks.keep("n", std::vector<std::uint32_t>{7}, {1});
  return encodeRequest(MessageId::of(1), "m", body) + encodeRequest(MessageId::of(2), "n", "{}");
}

void expectBothRequests(MessageReader& reader, std::size_t count) {
  const Message first = messageOf(reader.next());
  ASSERT_NE(first.payload.blocks(), nullptr);
  const Blocks& blocks = *first.payload.blocks();
  const auto x = blocks.doubles(*blocks.find("x"));
  ASSERT_EQ(x.size(), count);
  EXPECT_EQ(x[count - 1], 0.1 * static_cast<double>(count - 1));
  EXPECT_EQ(blocks.integers(*blocks.find("n"))[0], 7U);
  EXPECT_EQ(blocks.find("y"), nullptr);
  const Message second = messageOf(reader.next());
  EXPECT_EQ(second.method, "n");
  EXPECT_EQ(second.payload.blocks(), nullptr);
}

TEST(MessageReader, BlocksComeWithTheirMessageHoweverTheBytesArriveInPieces) {
  const std::string bytes = twoRequests(5);
  for (std::size_t piece = 1; piece <= bytes.size(); ++piece) {
    MessageReader reader{FrameLimits{}};
    reader.allowBlocks();
    for (std::size_t i = 0; i < bytes.size(); i += piece) {
      EXPECT_EQ(reader.hasPartialMessage(), i > 0 && reader.hasPartialMessage());
      reader.feed(std::string_view(bytes).substr(i, piece));
    }
    expectBothRequests(reader, 5);
    EXPECT_FALSE(reader.next().has_value());
    EXPECT_FALSE(reader.hasPartialMessage());
  }
}

TEST(MessageReader, APieceMayHaveTheEndOfABlockAndTheNextMessage) {
  const std::string bytes = twoRequests(5);
  for (std::size_t piece = 1; piece <= bytes.size(); ++piece) {
    MessageReader reader{FrameLimits{}};
    reader.allowBlocks();
    std::vector<std::string> methods;
    // read after each piece, so that blocks wait for their rest
    for (std::size_t i = 0; i < bytes.size(); i += piece) {
      reader.feed(std::string_view(bytes).substr(i, piece));
      for (auto read = reader.next(); read.has_value(); read = reader.next()) {
        methods.push_back(messageOf(std::move(read)).method);
      }
    }
    EXPECT_EQ(methods.size(), 2U) << piece;
    EXPECT_FALSE(reader.hasPartialMessage()) << piece;
  }
}

TEST(MessageReader, BlocksThatWereNotAgreedLoseTheFraming) {
  MessageReader reader{FrameLimits{}};
  reader.feed(twoRequests(5));
  EXPECT_FALSE(reader.next().has_value());
  ASSERT_TRUE(reader.lost().has_value());
  EXPECT_EQ(reader.lost()->code, ErrorCode::Capability);
  EXPECT_EQ(reader.lost()->message.find("Binary blocks were not agreed on. Name the capability 'bin' in hello"), 0U);
  EXPECT_FALSE(reader.next().has_value());
}

TEST(MessageReader, ABlockAtItsBoundIsReadAndOneByteMoreLosesTheFraming) {
  const std::string bytes = twoRequests(5);
  MessageReader wide{{.lineBytes = 1'000, .blockBytes = 48}};
  wide.allowBlocks();
  wide.feed(bytes);
  expectBothRequests(wide, 5);
  MessageReader narrow{{.lineBytes = 1'000, .blockBytes = 47}};
  narrow.allowBlocks();
  narrow.feed(bytes);
  EXPECT_FALSE(narrow.next().has_value());
  EXPECT_EQ(narrow.lost()->message.find("the limit 'blockBytes' is 47, and this is 48. "), 0U) << narrow.lost()->message;
}

TEST(MessageReader, ALineBeyondItsBoundLosesTheFraming) {
  MessageReader reader{{.lineBytes = 10, .blockBytes = 100}};
  reader.feed("01234567890");
  EXPECT_FALSE(reader.next().has_value());
  EXPECT_EQ(reader.lost()->message.find("the limit 'lineBytes' is 10, and this is 11. "), 0U);
}

TEST(MessageReader, AMessageWithWrongBlocksIsRefusedAndTheNextOneRead) {
  const auto problem = [](const std::string& members) {
    MessageReader reader{FrameLimits{}};
    reader.allowBlocks();
    reader.feed(R"({"jsonrpc":"2.0","id":1,"method":"m","params":{},)" + members + "}\n" + std::string(16, 'x') +
                encodeRequest(MessageId::of(2), "n", "{}"));
    auto read = reader.next();
    EXPECT_TRUE(read.has_value() && !read->has_value()) << members;
    EXPECT_EQ(messageOf(reader.next()).method, "n") << members;
    return read->error().error.message;
  };
  const auto block = [](const std::string& rest) {
    return R"("binBytes":16,"bin":[{"name":"a","dtype":"<f8","shape":[1],"offset":0,"bytes":8},{)" + rest + "}]";
  };
  EXPECT_EQ(problem(block(R"("name":"a","dtype":"<f8","shape":[1],"offset":8,"bytes":8)")),
            "bin[1].name: 'a' is there twice");
  EXPECT_EQ(problem(block(R"("name":"b","dtype":">f8","shape":[1],"offset":8,"bytes":8)")),
            "bin[1].dtype: expected one of <f8, <f4, <u4, found \">f8\"");
  EXPECT_EQ(problem(block(R"("name":"b","dtype":"<f8","shape":[2],"offset":8,"bytes":8)")),
            "bin[1].bytes: shape and dtype make 16 bytes, found 8");
  EXPECT_EQ(problem(block(R"("name":"b","dtype":"<f8","shape":[4294967296,4294967296],"offset":8,"bytes":0)")),
            "bin[1].bytes: shape and dtype make too many bytes, found 0");
  EXPECT_EQ(problem(block(R"("name":"b","dtype":"<f4","shape":[1],"offset":4,"bytes":4)")),
            "bin[1].offset: expected a multiple of 8, found 4");
  EXPECT_EQ(problem(block(R"("name":"b","dtype":"<f8","shape":[2],"offset":8,"bytes":16)")),
            "bin[1].offset: the block ends beyond binBytes=16");
  EXPECT_EQ(problem(block(R"("name":"b","dtype":"<u4","shape":[3],"offset":0,"bytes":12)")),
            "bin[1].offset: 'b' overlaps 'a'");
  EXPECT_EQ(problem(R"("binBytes":16,"bin":[{"name":"a","dtype":"<u4","shape":[3],"offset":0,"bytes":12},)"
                    R"({"name":"b","dtype":"<u4","shape":[1],"offset":8,"bytes":4}])"),
            "bin[1].offset: 'b' overlaps 'a'");
  EXPECT_EQ(problem(block(R"("name":"b","dtype":"<u4","shape":[1,1,1,1],"offset":8,"bytes":4)")),
            "bin[1].shape: expected at most 3 dimensions");
  EXPECT_EQ(problem(block(R"("name":"","dtype":"<u4","shape":[1],"offset":8,"bytes":4)")),
            "bin[1].name: expected 1 to 64 bytes");
  EXPECT_EQ(problem(R"("binBytes":16)"), "bin: expected an array, found nothing");
}

TEST(WebSocketFrame, ABinaryFrameCarriesWhatTheStreamCarries) {
  const std::string bytes = twoRequests(3);
  const std::string message = bytes.substr(0, bytes.size() - encodeRequest(MessageId::of(2), "n", "{}").size());
  EXPECT_TRUE(hasBlocks(message));
  EXPECT_FALSE(hasBlocks("{}\n"));
  const std::string frame = binaryFrame(message);
  EXPECT_EQ((frame.size() - 32) % 8, 0U);
  BulkTextReader bulk;
  std::optional<Error> problem;
  const Message read = messageOf(readFrame(frame, true, true, bulk, problem));
  EXPECT_EQ(read.payload.blocks()->doubles(*read.payload.blocks()->find("x")).size(), 3U);
  // cut off, with a wrong length, or not agreed
  EXPECT_FALSE(readFrame(frame, true, false, bulk, problem).has_value());
  EXPECT_EQ(problem->code, ErrorCode::Capability);
  EXPECT_FALSE(readFrame(frame.substr(0, 3), true, true, bulk, problem).has_value());
  EXPECT_EQ(problem->message, "A binary frame begins with the length of its JSON in four bytes.");
  EXPECT_FALSE(readFrame(frame.substr(0, 20), true, true, bulk, problem).has_value());
  EXPECT_NE(problem->message.find("A binary frame of 20 bytes cannot have"), std::string::npos);
  // one byte more than there is
  EXPECT_FALSE(readFrame(std::string("\3\0\0\0{}", 6), true, true, bulk, problem).has_value());
  EXPECT_EQ(problem->message, "A binary frame of 6 bytes cannot have 3 bytes of JSON.");
  const auto cut = readFrame(frame.substr(0, frame.size() - 8), true, true, bulk, problem);
  EXPECT_EQ(cut->error().error.message, "binBytes: the frame has 24 raw bytes behind its JSON, found 32");
}

TEST(WebSocketFrame, TheRawBytesBeginAtTheNextMultipleOfEightForEveryLengthOfTheJson) {
  std::size_t aligned = 0;
  for (std::size_t extra = 0; extra < 16; ++extra) {
    const std::string line = R"({"jsonrpc":"2.0","id":1,"method":"m","params":{"text":")" + std::string(extra, 'x') +
                             R"("},"binBytes":8,"bin":[{"name":"a","dtype":"<f8","shape":[1],"offset":0,"bytes":8}]})";
    const double value = 1.5;
    const std::string raw(reinterpret_cast<const char*>(&value), sizeof(value));
    // no byte more than the four of the length, the JSON and up to seven zeros
    const std::string frame = binaryFrame(line + "\n" + raw);
    const std::size_t head = 4 + line.size();
    const std::size_t padding = (head + 7) / 8 * 8 - head;
    aligned += padding == 0 ? 1U : 0U;
    EXPECT_EQ(frame.substr(4), line + std::string(padding, '\0') + raw) << line.size();
    BulkTextReader bulk;
    std::optional<Error> problem;
    const Message read = messageOf(readFrame(frame, true, true, bulk, problem));
    EXPECT_EQ(read.payload.blocks()->doubles(*read.payload.blocks()->find("a"))[0], 1.5) << line.size();
    EXPECT_FALSE(problem.has_value());
  }
  EXPECT_EQ(aligned, 2U);
}

}  // namespace
}  // namespace espalier::protocol::framing_test

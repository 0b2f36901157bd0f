#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "protocol/codec.h"
#include "protocol/framing.h"
#include "tests/protocol/decoding/problem.h"

namespace espalier::protocol::decode_environment_test {
namespace {

Payload payload(const std::string& member, const std::string& json) {
  const std::string method = member == "params" ? R"("method":"m",)" : "";
  return decodeMessage(R"({"jsonrpc":"2.0","id":1,)" + method + "\"" + member + "\":" + json + "}").value().payload;
}

/// Two queries, one with everything and one with little.
struct Example {
  std::vector<std::uint32_t> plant{2, 0}, symbol{0, 0}, following{1, QueryColumns::kNoSymbol};
  std::vector<std::uint64_t> module{77, 80}, offset{0, 2, 3}, followingOffset{0, 1, 1};
  std::vector<std::uint8_t> isTransient{1, 0};
  std::vector<double> parameters{0.1, -0.0, 5.0}, position{1.0, 2.0, 3.0, -0.0, 1e-300, 0.1}, width{0.5, 2.0},
      followingParameters{9.0};

  [[nodiscard]] EnvironmentStepParams params() const {
    EnvironmentStepParams step;
    step.simulation = "s";
    step.step = 4;
    step.timeDays = 0.25;
    QueryColumns& q = step.queries;
    q.count = 2;
    q.plant = plant;
    q.module = module;
    q.isTransient = isTransient;
    q.symbol = symbol;
    q.offset = offset;
    q.parameters = parameters;
    q.position = position;
    q.width = width;
    q.following = following;
    q.followingOffset = followingOffset;
    q.followingParameters = followingParameters;
    q.symbols = {"E", "F"};
    return step;
  }
};

/// The payload of a message that crossed as bytes.
Payload crossed(const std::string& bytes) {
  MessageReader reader{FrameLimits{}};
  reader.allowBlocks();
  reader.feed(bytes);
  auto read = reader.next();
  EXPECT_TRUE(read.has_value());
  if (!*read) {
    ADD_FAILURE() << read->error().error.message;
    return {};
  }
  return read->value().payload;
}

TEST(DecodeEnvironment, ReadsBackTheQueriesItWroteAsTextAndInBlocks) {
  const Example example;
  const auto step = example.params();
  const auto text =
      decodeEnvironmentStepParams(crossed(encodeRequest(MessageId::of(1), "environment.step", encode(step)))).value();
  EXPECT_EQ(encode(text), encode(step));
  EXPECT_TRUE(std::signbit(text.queries.parameters[1]));
  EXPECT_TRUE(text.queries.heading.empty());
  const auto blocks =
      decodeEnvironmentStepParams(crossed(encodeRequest(MessageId::of(1), "environment.step", encodeBlocks(step))))
          .value();
  EXPECT_EQ(encode(blocks), encode(step));
  EXPECT_TRUE(std::signbit(blocks.queries.parameters[1]));
}

TEST(DecodeEnvironment, QueriesWithoutParametersCrossInBlocks) {
  Example example;
  example.offset = {0, 0, 0};
  example.parameters = {};
  example.followingOffset = {0, 0, 0};
  example.followingParameters = {};
  const auto step = example.params();
  const auto blocks =
      decodeEnvironmentStepParams(crossed(encodeRequest(MessageId::of(1), "environment.step", encodeBlocks(step))))
          .value();
  EXPECT_EQ(encode(blocks), encode(step));
}

TEST(DecodeEnvironment, MembersThatOnlySomeQueriesHaveGetTheirDefaultInTheOthers) {
  const auto step =
      decodeEnvironmentStepParams(
          payload(
              "params",
              R"({"simulation":"s","step":0,"queries":[{"id":0,"symbol":"E"},{"id":1,"symbol":"E","position":[1,2,3],)"
              R"("width":4,"following":{"symbol":"F","parameters":[7]}},{"id":2,"symbol":"E"}]})"))
          .value();
  const auto list = [](const auto& column) { return std::vector(column.begin(), column.end()); };
  EXPECT_EQ(list(step.queries.position), (std::vector<double>{0, 0, 0, 1, 2, 3, 0, 0, 0}));
  EXPECT_EQ(list(step.queries.width), (std::vector<double>{1, 4, 1}));
  EXPECT_EQ(list(step.queries.following), (std::vector<std::uint32_t>{0xFFFFFFFF, 1, 0xFFFFFFFF}));
  EXPECT_EQ(list(step.queries.followingOffset), (std::vector<std::uint64_t>{0, 0, 1, 1}));
}

/// The problem of blocks of a step of one query, or of its replies.
std::string blockProblem(const std::string& head, const BlockWriter& blocks, bool isReply) {
  Body body(head);
  body.blocks = blocks;
  const Payload payload = crossed(isReply ? encodeResult(MessageId::of(1), body)
                                          : encodeRequest(MessageId::of(1), "environment.step", body));
  return isReply ? problem(decodeReplies(payload, 2)) : problem(decodeEnvironmentStepParams(payload));
}

TEST(DecodeEnvironment, BlocksOfAStepAreCheckedOneByOne) {
  const std::string head = R"({"simulation":"s","step":0,"symbols":["E"]})";
  using Numbers = std::vector<double>;
  using Counts = std::vector<std::uint32_t>;
  const auto with = [&](const std::function<void(BlockWriter&)>& change) {
    BlockWriter blocks;
    blocks.keep("plant", Counts{0, 0}, {2});
    change(blocks);
    return blockProblem(head, blocks, false);
  };
  EXPECT_EQ(with([](BlockWriter&) {}), "bin.symbol: the block is missing");
  EXPECT_EQ(with([](BlockWriter& b) { b.keep("symbol", Counts{0}, {1}); }),
            "bin.symbol: expected the shape [2], found [1]");
  EXPECT_EQ(with([](BlockWriter& b) {
              b.keep("symbol", Numbers{0, 0}, {2});
            }),
            "bin.symbol: expected the dtype <u4, found <f8");
  EXPECT_EQ(with([](BlockWriter& b) {
              b.keep("symbol", Counts{0, 3}, {2});
            }),
            "bin.symbol[1]: there is no symbol 3; params.symbols has 1");
  const auto withSymbol = [&](const std::function<void(BlockWriter&)>& change) {
    return with([&](BlockWriter& blocks) {
      blocks.keep("symbol", Counts{0, 0}, {2});
      change(blocks);
    });
  };
  EXPECT_EQ(withSymbol([](BlockWriter&) {}), "bin.parameters: the block is missing");
  EXPECT_EQ(withSymbol([](BlockWriter& b) {
              b.keep("parameters", Counts{1, 2}, {2, 1});
            }),
            "bin.parameters: expected the dtype <f8 or <f4, found <u4");
  EXPECT_EQ(withSymbol([](BlockWriter& b) {
              b.keep("parameters", Numbers{1, 2, 3}, {3});
            }),
            "bin.parameterOffset: the block is missing");
  EXPECT_EQ(withSymbol([](BlockWriter& b) {
              b.keep("parameters", Numbers{1, 2, 3}, {3});
              b.keep("parameterOffset", Counts{0, 2, 1}, {3});
            }),
            "bin.parameterOffset[2]: expected offsets that rise from 0 to 3, found 1");
  EXPECT_EQ(withSymbol([](BlockWriter& b) {
              b.keep("parameters", Numbers{1, NAN}, {2, 1});
            }),
            "bin.parameters[1]: NaN and infinity are not numbers of the protocol");
  EXPECT_EQ(withSymbol([](BlockWriter& b) {
              b.keep("parameters", Numbers{1, 2}, {2, 1});
              b.keep("position", Numbers{1, 2}, {2});
            }),
            "bin.position: expected the shape [2,3], found [2]");
  EXPECT_EQ(withSymbol([](BlockWriter& b) { b.keep("parameters", Numbers{1, 2}, {2, 1}); }), "(accepted)");
}

TEST(DecodeEnvironment, BlocksOfRepliesAreCheckedAgainstTheQueries) {
  using Numbers = std::vector<double>;
  using Counts = std::vector<std::uint32_t>;
  const auto with = [&](const std::function<void(BlockWriter&)>& change) {
    BlockWriter blocks;
    change(blocks);
    return blockProblem("{}", blocks, true);
  };
  EXPECT_EQ(with([](BlockWriter& b) { b.keep("id", Counts{0}, {1}); }), "bin.parameters: the block is missing");
  EXPECT_EQ(with([](BlockWriter& b) {
              b.keep("parameters", Numbers{1, 2, 3}, {3});
            }),
            "bin.parameters: expected a row for each of the 2 queries, or a block 'id' that says which are answered, "
            "found 3 rows");
  EXPECT_EQ(with([](BlockWriter& b) {
              b.keep("parameters", Numbers{}, {1'000'000'000'000, 0});
            }),
            "bin.parameters: expected a row for each of the 2 queries, or a block 'id' that says which are answered, "
            "found 1000000000000 rows");
  EXPECT_EQ(with([](BlockWriter& b) {
              b.keep("id", Counts{1, 1}, {2});
              b.keep("parameters", Numbers{1, 2}, {2, 1});
            }),
            "bin.id[1]: query 1 is answered twice; answer each at most once");
  EXPECT_EQ(with([](BlockWriter& b) {
              b.keep("parameters", Numbers{1, 2}, {2, 1});
              b.keep("set", Counts{1}, {1});
            }),
            "bin.set: expected the shape [2,1] of 'parameters', found [1]");
  EXPECT_EQ(with([](BlockWriter& b) { b.keep("parameters", std::vector<float>{1, 2}, {2}); }), "(accepted)");
}

TEST(DecodeEnvironment, RepliesInBlocksReadAsTheSameRepliesAsText) {
  BlockWriter blocks;
  blocks.keep("id", std::vector<std::uint32_t>{1, 0}, {2});
  blocks.keep("parameterOffset", std::vector<std::uint32_t>{0, 2, 3}, {3});
  blocks.keep("parameters", std::vector<double>{0.0, 0.3, 1.0}, {3});
  blocks.keep("set", std::vector<std::uint32_t>{0, 1, 1}, {3});
  Body body("{}");
  body.blocks = blocks;
  const auto replies = decodeReplies(crossed(encodeResult(MessageId::of(1), body)), 2).value();
  EXPECT_EQ(encode(replies), R"({"replies":[{"id":1,"parameters":[null,0.3]},{"id":0,"parameters":[1]}]})");
  // and once more
  const auto again = decodeReplies(crossed(encodeResult(MessageId::of(1), encodeBlocks(replies))), 2).value();
  EXPECT_EQ(encode(again), encode(replies));
}

TEST(DecodeEnvironment, NotesComeWithRepliesAsTextAndInBlocks) {
  const std::string text = R"({"replies":[{"id":0,"parameters":[1]}],"notes":["it is dark","it is dry"]})";
  const auto replies = decodeReplies(crossed(encodeResult(MessageId::of(1), text)), 1).value();
  EXPECT_EQ(encode(replies), text);
  const auto again = decodeReplies(crossed(encodeResult(MessageId::of(1), encodeBlocks(replies))), 1).value();
  EXPECT_EQ(again.notes, (std::vector<std::string>{"it is dark", "it is dry"}));
}

TEST(DecodeEnvironment, NotesAreBounded) {
  const auto notesOf = [](const std::string& notes) {
    return decodeReplies(crossed(encodeResult(MessageId::of(1), R"({"replies":[],"notes":)" + notes + "}")), 0);
  };
  std::string many = "[";
  for (int i = 0; i < 60; ++i) {
    many += "\"x\",";
  }
  EXPECT_EQ(notesOf(many + "\"y\"]").value().notes, std::vector<std::string>(50, "x"));
  // not cut within a character
  const std::string cut = notesOf("[\"" + std::string(999, 'x') + "\u00e9\"]").value().notes.at(0);
  EXPECT_EQ(cut, std::string(999, 'x'));
  EXPECT_EQ(notesOf("[1]").error().message, "result.notes[0]: expected a text, found 1");
}

TEST(DecodeEnvironment, RepliesAreCheckedAgainstTheQueries) {
  const auto decode = [](const std::string& replies) { return decodeReplies(payload("result", replies), 2); };
  EXPECT_EQ(problem(decode(R"({"replies":[{"id":2,"parameters":[1]}]})")),
            "result.replies[0].id: there is no query 2; this step has 2 queries, numbered from 0");
  EXPECT_EQ(problem(decode(R"({"replies":[{"id":1},{"id":1}]})")),
            "result.replies[1].id: query 1 is answered twice; answer each at most once");
  EXPECT_EQ(problem(decode(R"({"replies":[{"id":0,"parameters":[1,true]}]})")),
            "result.replies[0].parameters[1]: expected a number, found true");
  EXPECT_EQ(problem(decode("[]")), "result: expected an object, found an array");
  const auto replies = decode(R"({"replies":[{"id":1,"parameters":[null,0.3]}]})").value();
  EXPECT_EQ(encode(replies), R"({"replies":[{"id":1,"parameters":[null,0.3]}]})");
}

TEST(DecodeEnvironment, ADescriptionMayLeaveOutEverything) {
  const auto empty = decodeDescribeResult(payload("result", "{}")).value();
  EXPECT_EQ(empty.needs, NeedsRecord{});
  EXPECT_FALSE(empty.isStateful);
  EXPECT_EQ(
      problem(decodeDescribeResult(payload("result", R"({"needs":["colour"]})"))),
      "result.needs[0]: expected one of position, heading, left, up, width, scale, parameters, following, geometry, "
      "found \"colour\"");
}

TEST(DecodeEnvironment, QueriesMustBeNumberedInOrder) {
  EXPECT_EQ(problem(decodeEnvironmentStepParams(
                payload("params", R"({"simulation":"s","step":0,"queries":[{"id":1,"symbol":"E"}]})"))),
            "params.queries[0].id: expected 0: queries are numbered from 0 in order");
}

TEST(DecodeEnvironment, OpenCarriesSeedsOf64Bits) {
  OpenParams open;
  open.simulation = "s";
  open.seed = UINT64_MAX;
  open.resumeStep = 5;
  open.world.latitudeDegrees = 50.5;
  const auto read = decodeOpenParams(payload("params", encode(open))).value();
  EXPECT_EQ(encode(read), encode(open));
}

}  // namespace
}  // namespace espalier::protocol::decode_environment_test

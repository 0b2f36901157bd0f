#include <gtest/gtest.h>

#include <cmath>

#include "protocol/codec.h"

namespace espalier::protocol {
namespace {

Payload payload(const std::string& member, const std::string& json) {
  const std::string method = member == "params" ? R"("method":"m",)" : "";
  return std::get<Message>(decodeMessage(R"({"jsonrpc":"2.0","id":1,)" + method + "\"" + member + "\":" + json + "}"))
      .payload;
}

template <typename T>
std::string problem(const Decoded<T>& decoded) {
  const auto* error = std::get_if<Error>(&decoded);
  return error == nullptr ? "(accepted)" : error->message;
}

TEST(DecodeEnvironment, ReadsBackTheQueriesItWrote) {
  EnvironmentStepParams step;
  step.simulation = "s";
  step.step = 4;
  step.timeDays = 0.25;
  QueryRecord query;
  query.plant = 2;
  query.module = 77;
  query.isTransient = true;
  query.symbol = "E";
  query.parameters = {0.1, -0.0};
  query.position = {1.0, 2.0, 3.0};
  query.followingSymbol = "F";
  query.followingParameters = {9.0};
  step.queries = {query};
  const auto read = std::get<EnvironmentStepParams>(decodeEnvironmentStepParams(payload("params", encode(step))));
  EXPECT_EQ(encode(read), encode(step));
  EXPECT_TRUE(std::signbit(read.queries[0].parameters[1]));
  EXPECT_FALSE(read.queries[0].heading.has_value());
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
  const auto replies = std::get<std::vector<ReplyRecord>>(decode(R"({"replies":[{"id":1,"parameters":[null,0.3]}]})"));
  EXPECT_EQ(replies.at(0).parameters, (std::vector<std::optional<double>>{std::nullopt, 0.3}));
}

TEST(DecodeEnvironment, ADescriptionMayLeaveOutEverything) {
  const auto empty = std::get<DescribeResult>(decodeDescribeResult(payload("result", "{}")));
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
  const auto read = std::get<OpenParams>(decodeOpenParams(payload("params", encode(open))));
  EXPECT_EQ(encode(read), encode(open));
}

}  // namespace
}  // namespace espalier::protocol

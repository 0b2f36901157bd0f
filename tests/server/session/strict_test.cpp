// Unknown members of requests: errors where `strict` was agreed on, otherwise warnings in the answer.

#include "protocol/json_text.h"
#include "tests/server/raw_peer.h"

namespace espalier::server::strict_test {
namespace {

constexpr const char* kStrict =
    R"({"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1],"capabilities":["strict"]}})";
constexpr const char* kMisspelt =
    R"({"jsonrpc":"2.0","id":2,"method":"simulation.create","params":{"model":{"source":"Lsystem: 1\nAxiom: A\nendlsystem\n"},"sed":7}})";

TEST(Strict, AnUnknownMemberIsRefusedWithTheNearestName) {
  const RunningServer server;
  RawPeer peer(server);
  EXPECT_NE(peer.ask(kStrict).find("\"strict\""), std::string::npos);
  const std::string error = member(peer.ask(kMisspelt), "error");
  EXPECT_EQ(member(error, "code"), "-32602");
  EXPECT_EQ(member(error, "message"), "params.sed: there is no such member. Did you mean 'seed'?");
  EXPECT_EQ(member(member(error, "data"), "path"), "params.sed");
  // nothing was created
  EXPECT_EQ(member(member(peer.ask(R"({"jsonrpc":"2.0","id":3,"method":"simulation.list"})"), "result"), "simulations"),
            "[]");
}

TEST(Strict, WithoutItTheAnswerWarns) {
  const RunningServer server;
  RawPeer peer(server);
  peer.ask(kHello);
  const std::string result = member(peer.ask(kMisspelt), "result");
  EXPECT_EQ(member(result, "warnings"), R"(["params.sed: there is no such member. Did you mean 'seed'?"])");
  EXPECT_EQ(member(result, "step"), "0");
  // the next answer has none
  const std::string status = peer.ask(R"({"jsonrpc":"2.0","id":4,"method":"server.status"})");
  EXPECT_EQ(status.find("warnings"), std::string::npos);
}

TEST(Strict, NestedMembersAreKnownByTheirPath) {
  const RunningServer server;
  RawPeer peer(server);
  peer.ask(kStrict);
  const std::string error = member(
      peer.ask(
          R"({"jsonrpc":"2.0","id":2,"method":"simulation.create","params":{"model":{"gallery":"a","mian":"b"},"limits":{"module":5},"plants":[{"position":[0,0,0]},{"positon":[0,0,0]}]}})"),
      "error");
  EXPECT_NE(member(error, "message").find("params."), std::string::npos);
  EXPECT_EQ(member(error, "code"), "-32602") << error;
}

TEST(Strict, ParametersFilesAndEnvironmentsAreNotItsBusiness) {
  const RunningServer server;
  RawPeer peer(server);
  peer.ask(kStrict);
  const std::string answer = peer.ask(
      R"({"jsonrpc":"2.0","id":2,"method":"simulation.create","params":{"model":{"files":{"a.l":"#define R 1\nLsystem: 1\nAxiom: F(R)?E(0)\nendlsystem\n","a.v":"angle factor: 4\n"},"main":"a.l"},"parameters":{"R":2},"environment":[{"type":"honda","radius":0.5}]}})");
  EXPECT_EQ(member(member(answer, "result"), "step"), "0") << answer;
}

TEST(Running, InformationSaysThatNothingRuns) {
  const RunningServer server;
  RawPeer peer(server);
  peer.ask(kHello);
  const std::string made = member(
      peer.ask(
          R"({"jsonrpc":"2.0","id":2,"method":"simulation.create","params":{"model":{"source":"Lsystem: 1\nAxiom: A\nendlsystem\n"}}})"),
      "result");
  const std::string answer =
      peer.ask(R"({"jsonrpc":"2.0","id":3,"method":"simulation.get","params":{"what":"information","simulation":")" +
               member(made, "simulation") + "\"}}");
  EXPECT_EQ(member(member(member(answer, "result"), "information"), "running"), "false") << answer;
}

}  // namespace
}  // namespace espalier::server::strict_test

#include "server/session.h"

#include "raw_peer.h"

namespace espalier::server {
namespace {

using ::testing::Test;

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

TEST(Session, HelloAgreesOnTheVersionAndTellsTheLimits) {
  const RunningServer server;
  RawPeer peer(server);
  const std::string answer = peer.ask(kHello);
  const std::string result = member(answer, "result");
  EXPECT_EQ(member(answer, "id"), "1");
  EXPECT_EQ(member(result, "protocol"), "1");
  EXPECT_EQ(member(member(result, "limits"), "sessions"), "1000");
}

TEST(Session, RefusesAPeerWithoutACommonVersionAndCloses) {
  const RunningServer server;
  RawPeer peer(server);
  const std::string answer = peer.ask(R"({"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[2,3]}})");
  EXPECT_EQ(member(member(answer, "error"), "code"), "1001");
  EXPECT_EQ(member(member(answer, "error"), "message"),
            "No common protocol version: this server speaks 1. Use a client that speaks espalier/1.");
  EXPECT_EQ(peer.line(), "(closed)");
}

TEST(Session, ServesNothingBeforeHelloAndStillTakesItAfterwards) {
  const RunningServer server;
  RawPeer peer(server);
  EXPECT_EQ(member(member(peer.ask(R"({"jsonrpc":"2.0","id":9,"method":"server.status"})"), "error"), "code"), "1012");
  EXPECT_EQ(member(member(peer.ask(kHello), "result"), "protocol"), "1");
  EXPECT_EQ(member(member(peer.ask(kHello), "error"), "code"), "-32600");
}

TEST(Session, ARequestWhoseIdIsNullIsAnsweredWithNull) {
  const RunningServer server;
  RawPeer peer(server);
  EXPECT_EQ(member(member(peer.ask(kHello), "result"), "protocol"), "1");
  const std::string answer = peer.ask(R"({"jsonrpc":"2.0","id":null,"method":"server.status"})");
  EXPECT_EQ(member(answer, "id"), "null");
  EXPECT_EQ(member(member(answer, "result"), "protocol"), "1");
}

TEST(Session, AnUnfinishedHandshakeTimesOut) {
  ServerOptions options;
  options.limits.handshakeMilliseconds = 50;
  const RunningServer server(options);
  RawPeer peer(server);
  const std::string answer = peer.line();
  EXPECT_EQ(member(member(answer, "error"), "code"), "1005");
  EXPECT_EQ(member(answer, "id"), "null");
  EXPECT_EQ(peer.line(), "(closed)");
}

TEST(Session, AsksForTheTokenAndClosesWhenItIsWrong) {
  ServerOptions options;
  options.token = "secret";
  const RunningServer server(options);
  RawPeer peer(server);
  EXPECT_EQ(member(member(peer.ask(kHello), "error"), "code"), "1003");
  EXPECT_EQ(peer.line(), "(closed)");
  client::ClientOptions good;
  good.token = "secret";
  EXPECT_NE(connectTo(server, good), nullptr);
}

TEST(Session, ARubbishLineIsAParseErrorWithIdNullAndTheSessionGoesOn) {
  const RunningServer server;
  RawPeer peer(server);
  (void)peer.ask(kHello);
  const std::string answer = peer.ask("this is not JSON");
  EXPECT_EQ(member(answer, "id"), "null");
  EXPECT_EQ(member(member(answer, "error"), "code"), "-32700");
  EXPECT_EQ(member(member(peer.ask(R"({"jsonrpc":"2.0","id":2,"method":"server.status"})"), "result"), "protocol"),
            "1");
}

TEST(Session, NamesThePathOfAWrongField) {
  const RunningServer server;
  RawPeer peer(server);
  (void)peer.ask(kHello);
  const std::string error = member(
      peer.ask(R"({"jsonrpc":"2.0","id":2,"method":"simulation.step","params":{"simulation":"x","steps":"three"}})"),
      "error");
  EXPECT_EQ(member(error, "code"), "-32602");
  EXPECT_EQ(member(error, "message"),
            "params.steps: expected a whole number from 1 to 9007199254740992, found \"three\"");
  EXPECT_EQ(member(member(error, "data"), "path"), "params.steps");
}

TEST(Session, AnUnknownMethodIsAnsweredWithTheNearestOne) {
  const RunningServer server;
  RawPeer peer(server);
  (void)peer.ask(kHello);
  const std::string error = member(peer.ask(R"({"jsonrpc":"2.0","id":2,"method":"simulation.stepp"})"), "error");
  EXPECT_EQ(member(error, "code"), "-32601");
  EXPECT_TRUE(contains(member(error, "message"), "Did you mean 'simulation.step'?")) << error;
}

TEST(Session, ALineBeyondTheLimitLosesTheFramingAndEndsTheSessionOnly) {
  ServerOptions options;
  options.limits.lineBytes = 1'000;
  const RunningServer server(options);
  const auto other = connectTo(server);
  RawPeer peer(server);
  (void)peer.ask(kHello);
  peer.send(std::string(5'000, 'x'));
  const std::string error = member(peer.line(), "error");
  EXPECT_EQ(member(error, "code"), "1004");
  EXPECT_EQ(member(member(error, "data"), "limit"), "lineBytes");
  EXPECT_EQ(member(member(error, "data"), "bound"), "1000");
  EXPECT_EQ(peer.line(), "(closed)");
  EXPECT_EQ(member(resultOf(other->request("server.status", "{}")), "protocol"), "1");
}

TEST(Session, DeeplyNestedBracketsAreRefusedAndHarmless) {
  const RunningServer server;
  RawPeer peer(server);
  (void)peer.ask(kHello);
  EXPECT_EQ(member(member(peer.ask(std::string(1'000'000, '[')), "error"), "code"), "-32700");
  EXPECT_EQ(member(member(peer.ask(R"({"jsonrpc":"2.0","id":2,"method":"server.status"})"), "result"), "protocol"),
            "1");
}

TEST(Session, AnswersThatNobodyAskedForAndNotificationsAreIgnored) {
  const RunningServer server;
  RawPeer peer(server);
  (void)peer.ask(kHello);
  peer.send("{\"jsonrpc\":\"2.0\",\"id\":\"s77\",\"result\":{}}\n");
  peer.send("{\"jsonrpc\":\"2.0\",\"id\":4,\"error\":{\"code\":1,\"message\":\"x\"}}\n");
  peer.send("{\"jsonrpc\":\"2.0\",\"method\":\"simulation.step\",\"params\":{}}\n");
  EXPECT_EQ(member(peer.ask(R"({"jsonrpc":"2.0","id":2,"method":"server.status"})"), "id"), "2");
}

TEST(Session, MessagesMayArriveInAnyPieces) {
  const RunningServer server;
  RawPeer peer(server);
  const std::string line = std::string(kHello) + "\r\n";
  for (const char byte : line) {
    peer.send({&byte, 1});
  }
  EXPECT_EQ(member(member(peer.line(), "result"), "protocol"), "1");
}

TEST(Session, MoreSessionsThanAllowedAreRefusedByName) {
  ServerOptions options;
  options.limits.sessions = 1;
  const RunningServer server(options);
  const auto first = connectTo(server);
  RawPeer second(server);
  EXPECT_EQ(member(member(member(second.line(), "error"), "data"), "limit"), "sessions");
  EXPECT_EQ(second.line(), "(closed)");
  EXPECT_EQ(member(resultOf(first->request("server.status", "{}")), "protocol"), "1");
}

TEST(Session, AnIdInProgressCannotBeUsedTwice) {
  const RunningServer server;
  const auto helper = connectTo(server);
  // a step that waits for an environment keeps its id busy
  std::atomic<bool> isAsked{false};
  const OfferingEnvironment silent(server, "silent", [&](client::Client& self, const client::IncomingRequest& request) {
    if (request.method != "environment.step") {
      (void)self.respondError(request.id, {protocol::ErrorCode::UnknownMethod, "no", {}});
    } else {
      isAsked = true;
      isAsked.notify_all();
    }
  });
  const std::string simulation = create(*helper, kGrowth, R"([{"type":"offered","name":"silent"}])");
  RawPeer peer(server);
  (void)peer.ask(kHello);
  const std::string step =
      R"({"jsonrpc":"2.0","id":5,"method":"simulation.step","params":{"simulation":")" + simulation + "\"}}";
  peer.send(step + "\n");
  isAsked.wait(false);
  EXPECT_EQ(member(member(peer.ask(step), "error"), "code"), "-32600");
  peer.send(R"({"jsonrpc":"2.0","method":"$/cancel","params":{"id":5}})"
            "\n");
  EXPECT_EQ(member(member(peer.line(), "error"), "code"), "1010");
}

}  // namespace
}  // namespace espalier::server

#include "server/session/session.h"

#include <fstream>
#include <future>

#include "engine/simulation/trace.h"
#include "protocol/base64.h"
#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "server/remote/trace_file.h"
#include "tests/server/raw_peer.h"

namespace espalier::server::session_test {
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

TEST(Session, AFloodBeforeHelloIsAnsweredAHundredTimes) {
  const RunningServer server;
  RawPeer peer(server);
  std::string flood;
  for (int i = 0; i < 5'000; ++i) {
    flood += i % 2 == 0 ? "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"ping\"}\n" : "no message\n";
  }
  peer.send(flood);
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(member(member(peer.line(), "error"), "code"), i % 2 == 0 ? "1012" : "-32700");
  }
  EXPECT_EQ(member(member(peer.line(), "error"), "message"),
            "100 messages came, and none was a hello that holds. Connect again and say hello first.");
  EXPECT_EQ(peer.line(), "(closed)");
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
  options.tokens = {tokenOf("alice", "secret", {protocol::Role::Controller})};
  const RunningServer server(options);
  RawPeer peer(server);
  EXPECT_EQ(member(member(peer.ask(kHello), "error"), "code"), "1003");
  EXPECT_EQ(peer.line(), "(closed)");
  client::ClientOptions good;
  good.token = "secret";
  EXPECT_NE(connectTo(server, good), nullptr);
}

TEST(Session, RunStopsAtTheStepThatItIsGiven) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kGrowth, R"([{"type":"height"}])");
  const std::string answer = resultOf(client->request("simulation.run", named(simulation, R"("until":2)")));
  EXPECT_EQ(member(answer, "step"), "2");
  EXPECT_EQ(member(answer, "truncated"), "false");
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
  EXPECT_EQ(member(member(member(second.ask(kHello), "error"), "data"), "limit"), "sessions");
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

constexpr std::string_view kBeatingHello =
    R"({"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1],"capabilities":["heartbeat"]}})";

TEST(Session, PingIsAnswered) {
  const RunningServer server;
  RawPeer peer(server);
  (void)peer.ask(kHello);
  EXPECT_EQ(member(peer.ask(R"({"jsonrpc":"2.0","id":7,"method":"ping"})"), "result"), "{}");
}

TEST(Session, APeerThatAgreedToHeartbeatsIsAskedAndGivenUpWhenItStaysSilent) {
  ServerOptions options;
  options.limits.heartbeatMilliseconds = 60;
  const RunningServer server(options);
  const auto watcher = connectTo(server);
  RawPeer peer(server);
  (void)peer.ask(kBeatingHello);
  (void)peer.ask(R"({"jsonrpc":"2.0","id":5,"method":"environment.offer","params":{"name":"mylight"}})");
  for (int beat = 1; beat <= 3; ++beat) {
    const std::string asked = peer.line();
    EXPECT_EQ(member(asked, "method"), "ping");
    EXPECT_EQ(member(asked, "id"), "h" + std::to_string(beat));
    // an error is a sign of life as well
    peer.send("{\"jsonrpc\":\"2.0\",\"id\":\"h" + std::to_string(beat) +
              (beat == 2 ? "\",\"error\":{\"code\":-32601,\"message\":\"unknown\"}}\n" : "\",\"result\":{}}\n"));
  }
  EXPECT_EQ(member(peer.line(), "method"), "ping");
  EXPECT_EQ(peer.line(), "(closed)");
  // the environment that it offered is away
  EXPECT_EQ(member(resultOf(watcher->request("server.status", "{}")), "offered"), "[]");
}

TEST(Session, WhoOwesTheAnswerToAStepOrDidNotAgreeIsNotAsked) {
  ServerOptions options;
  options.limits.heartbeatMilliseconds = 20;
  options.limits.environmentStepMilliseconds = 400;
  const RunningServer server(options);
  const auto client = connectTo(server);
  RawPeer peer(server);
  (void)peer.ask(kBeatingHello);
  (void)peer.ask(R"({"jsonrpc":"2.0","id":5,"method":"environment.offer","params":{"name":"mylight"}})");
  const auto id =
      client->send("simulation.create", createParams(kGrowth, R"([{"type":"offered","name":"mylight"}])")).value();
  // it computes its description for twenty heartbeats, and is still there
  std::string asked = peer.line();
  while (member(asked, "method") == "ping") {
    peer.send("{\"jsonrpc\":\"2.0\",\"id\":\"" + member(asked, "id") + "\",\"result\":{}}\n");
    asked = peer.line();
  }
  EXPECT_EQ(member(asked, "method"), "environment.describe");
  peer.send("{\"jsonrpc\":\"2.0\",\"id\":\"" + member(asked, "id") + "\",\"result\":{}}\n");
  asked = peer.line();
  EXPECT_EQ(member(asked, "method"), "environment.open");
  // the next that comes is not a ping: the limit of the step ends it
  const auto error = errorOf(client->waitFor(id, std::chrono::seconds(30)));
  EXPECT_NE(error.message.find("did not answer within 400 ms"), std::string::npos) << error.message;
  EXPECT_EQ(member(peer.line(), "method"), "ping");
}

TEST(Session, ATraceIsBegunEndedListedAndSent) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kGrowth, R"([{"type":"height"}])");
  const auto get = [&](const std::string& what) {
    return client->request("simulation.get", named(simulation, R"("what":)" + what));
  };
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(member(resultOf(get(R"("traces")")), "traces"), "[]");
  const std::string begun = resultOf(client->request("simulation.trace", named(simulation, R"("trace":true)")));
  EXPECT_EQ(begun, R"({"step":1,"traced":true})");
  resultOf(client->request("simulation.step", named(simulation, R"("steps":2)")));
  EXPECT_EQ(resultOf(client->request("simulation.trace", named(simulation, R"("trace":false)"))),
            R"({"step":3,"traced":false})");
  resultOf(client->request("simulation.step", named(simulation)));
  const std::string traces = member(resultOf(get(R"("traces")")), "traces");
  EXPECT_NE(traces.find(R"("trace":1)"), std::string::npos) << traces;
  EXPECT_EQ(traces.find(R"("trace":2)"), std::string::npos) << traces;
  const std::string sent = member(resultOf(get(R"("trace","trace":1)")), "content");
  const std::string file = folder.path() + "/sent.trace.zst";
  std::ofstream(file, std::ios::binary) << protocol::fromBase64(sent).value_or("");
  const auto source = TraceFileSource::open(file);
  ASSERT_TRUE(source.has_value());
  const auto replayed = simulation::replayTrace(**source, UINT64_MAX, 1);
  ASSERT_TRUE(replayed.has_value()) << replayed.error();
  EXPECT_EQ(replayed->steps, 2U);
  EXPECT_FALSE(replayed->divergence.has_value());
  EXPECT_EQ(
      errorOf(get(R"("trace","trace":2)")).message,
      "params.trace: there is no trace 2 of this simulation, it cannot be read now, or it is too large for an answer; "
      "ask for its traces, or download it over HTTP");
}

TEST(Session, AForkOfATracedSimulationHasATraceOfItsOwn) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string original = create(*client, kGrowth, R"([{"type":"height"}])", R"("trace":true)");
  resultOf(client->request("simulation.step", named(original)));
  const std::string fork = member(resultOf(client->request("simulation.fork", named(original))), "simulation");
  resultOf(client->request("simulation.step", named(fork, R"("steps":2)")));
  resultOf(client->request("simulation.trace", named(fork, R"("trace":false)")));
  const auto source = TraceFileSource::open(folder.path() + "/traces/" + fork + "-1.trace.zst");
  ASSERT_TRUE(source.has_value());
  const auto replayed = simulation::replayTrace(**source, UINT64_MAX, 1);
  ASSERT_TRUE(replayed.has_value()) << replayed.error();
  EXPECT_EQ(replayed->steps, 2U);
  EXPECT_FALSE(replayed->divergence.has_value());
}

TEST(Session, ALongCallSaysHowFarItIsWhenAsked) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kGrowth, R"([{"type":"height"}])");
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_FALSE(client->nextNotification(std::chrono::milliseconds(0)).has_value());
  const auto id = client->send("simulation.step", named(simulation, R"("steps":3,"progress":true)")).value();
  EXPECT_EQ(member(resultOf(client->waitFor(id, std::chrono::seconds(30))), "step"), "4");
  const auto told = client->nextNotification(std::chrono::seconds(0));
  ASSERT_TRUE(told.has_value());
  EXPECT_EQ(told->method, "$/progress");
  EXPECT_EQ(member(told->paramsJson, "id"), std::to_string(id));
  EXPECT_EQ(member(told->paramsJson, "step"), "2");
  EXPECT_EQ(member(told->paramsJson, "made"), "1");
}

TEST(Session, TurtleRecordsAreSelected) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kGrowth, R"([{"type":"height"}])");
  const auto records = [&](const std::string& select) {
    return member(resultOf(client->request("simulation.get", named(simulation, R"("what":"turtle")" + select))),
                  "records");
  };
  EXPECT_NE(records("").find(R"("symbol":"E")"), std::string::npos);
  const std::string lines = records(R"(,"select":{"symbols":["F"]})");
  EXPECT_NE(lines.find(R"("symbol":"F")"), std::string::npos);
  EXPECT_EQ(lines.find(R"("symbol":"E")"), std::string::npos);
  EXPECT_EQ(records(R"(,"select":{"plants":[1]})"), "[]");
}

TEST(Session, TheSpaceOfThePlantsIsToldToEnvironments) {
  const RunningServer server;
  const auto client = connectTo(server);
  std::promise<std::string> told;
  const OfferingEnvironment environment(
      server, "mylight", [&told](client::Client& self, const client::IncomingRequest& request) {
        if (request.method == "environment.open") {
          told.set_value(protocol::memberOf(request.params.toText(), "bounds").value_or("(none)"));
          (void)self.respond(request.id, protocol::Body("{}"));
          return;
        }
        (void)self.respondError(request.id, {protocol::ErrorCode::UnknownMethod, "no", {}});
      });
  (void)create(*client, kGrowth, R"([{"type":"offered","name":"mylight"}])", R"("bounds":[[-1,0,-1.5],[1,20,1]])");
  EXPECT_EQ(told.get_future().get(), "[[-1,0,-1.5],[1,20,1]]");
  const auto problem = [&](const std::string& bounds) {
    return errorOf(client->request("simulation.create", createParams(kGrowth, {}, R"("bounds":)" + bounds))).message;
  };
  EXPECT_EQ(problem("[[0,0,0]]").rfind("params.bounds: expected two corners of three numbers", 0), 0U);
  EXPECT_EQ(problem("[[0,5,0],[1,1,1]]"), "params.bounds: the first corner has the smaller coordinates");
}

TEST(Session, ATraceNeedsADataFolder) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kGrowth, R"([{"type":"height"}])");
  EXPECT_EQ(errorOf(client->request("simulation.trace", named(simulation, R"("trace":true)"))).message,
            "params.trace: this server keeps nothing; start it with --data to have traces");
}

TEST(Session, ACouplingIsIteratedOverTheWire) {
  const RunningServer server;
  const auto client = connectTo(server);
  // 1 + x / 2 of what was sent, without state
  const OfferingEnvironment environment(
      server, "halver", [](client::Client& self, const client::IncomingRequest& request) {
        if (request.method != "environment.step") {
          (void)self.respondError(request.id, {protocol::ErrorCode::UnknownMethod, "only steps here", {}});
          return;
        }
        const auto params = protocol::decodeEnvironmentStepParams(request.params).value();
        protocol::JsonWriter reply;
        reply.beginObject().key("replies").beginArray().beginObject().key("id").integer(0).key("parameters");
        reply.beginArray().number(1.0 + 0.5 * params.queries.parameters[0]).endArray().endObject().endArray();
        (void)self.respond(request.id, reply.endObject().take());
      });
  const std::string simulation =
      create(*client, "Lsystem: 1\nderivation length: 2\nAxiom: ?E(0)\n?E(x) --> ?E(x)\nendlsystem\n",
             R"([{"type":"offered","name":"halver"}])", R"("coupling":{"iterations":50,"tolerance":1e-3})");
  const std::string stepped = resultOf(client->request("simulation.step", named(simulation)));
  // the change halves from 1 to below 1/1000
  EXPECT_EQ(member(member(stepped, "statistics"), "iterations"), "11");
  EXPECT_EQ(errorOf(client->request("simulation.create", createParams(kGrowth, {}, R"("coupling":{"iterations":0})")))
                .message,
            "params.coupling.iterations: expected a whole number from 1 to 10000, found 0");
  EXPECT_EQ(errorOf(client->request("simulation.create",
                                    createParams(kGrowth, {}, R"("coupling":{"iterations":2,"tolerance":-1})")))
                .message,
            "params.coupling.tolerance: expected a number from 0 on, found -1");
}

}  // namespace
}  // namespace espalier::server::session_test

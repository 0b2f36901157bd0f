#include "server/stream/stream.h"

#include "tests/server/raw_peer.h"

namespace espalier::server::stream_test {
namespace {

constexpr std::string_view kChain = "Lsystem: 1\nderivation length: 50\nAxiom: FA\nA --> FA\nendlsystem\n";

std::string nextFrame(client::Client& client) {
  while (const auto notification = client.nextNotification(std::chrono::seconds(30))) {
    if (notification->method == "stream.data") {
      return notification->paramsJson;
    }
  }
  ADD_FAILURE() << "no frame came";
  return "{}";
}

TEST(Stream, SendsThePresentStateFirstAndThenEveryStep) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kChain);
  const std::string opened = resultOf(client->request("stream.open", named(simulation, R"("what":"string")")));
  resultOf(client->request("simulation.step", named(simulation, R"("steps":2)")));
  for (int step = 0; step <= 2; ++step) {
    const std::string frame = nextFrame(*client);
    EXPECT_EQ(member(frame, "stream"), member(opened, "stream"));
    EXPECT_EQ(member(frame, "step"), std::to_string(step));
    EXPECT_EQ(member(frame, "sequence"), std::to_string(step));
    EXPECT_EQ(member(frame, "key"), "true");
    EXPECT_EQ(member(frame, "missed"), "0");
    EXPECT_EQ(member(frame, "string"), "F" + std::string(static_cast<std::size_t>(step), 'F') + "A");
  }
}

TEST(Stream, TurtleRecordsCanBeSelectedBySymbolAndKeepTheirIndex) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation =
      create(*client, "Lsystem: 1\nderivation length: 1\nAxiom: F(2)[+(90)G(3)]\nZ --> Z\nendlsystem\n");
  resultOf(client->request("stream.open", named(simulation, R"("what":"turtle","select":{"symbols":["G"]})")));
  const std::string records = member(nextFrame(*client), "records");
  EXPECT_NE(records.find("\"symbol\":\"G\""), std::string::npos) << records;
  EXPECT_EQ(records.find("\"symbol\":\"F\""), std::string::npos) << records;
  EXPECT_NE(records.find("\"index\":"), std::string::npos) << records;
}

TEST(Stream, EverySelectsTheSteps) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kChain);
  resultOf(client->request("stream.open", named(simulation, R"("what":"statistics","every":3)")));
  resultOf(client->request("simulation.step", named(simulation, R"("steps":7)")));
  EXPECT_EQ(member(nextFrame(*client), "step"), "0");
  EXPECT_EQ(member(nextFrame(*client), "step"), "3");
  EXPECT_EQ(member(nextFrame(*client), "step"), "6");
}

TEST(Stream, AViewerWithoutCreditIsMovedToTheLatestFrameAndToldHowManyItMissed) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kChain);
  const std::string stream =
      member(resultOf(client->request("stream.open", named(simulation, R"("what":"string","credits":1)"))), "stream");
  resultOf(client->request("simulation.step", named(simulation, R"("steps":10)")));
  const std::string first = nextFrame(*client);
  EXPECT_EQ(member(first, "step"), "0");
  // frames are made beside the steps: one of a step before the last may come first
  int seen = 0;
  std::string latest = first;
  for (int sequence = 0; member(latest, "step") != "10"; ++sequence) {
    const std::string ack = "{\"stream\":\"" + stream + "\",\"sequence\":" + std::to_string(sequence) + "}";
    EXPECT_FALSE(client->notify("stream.ack", ack).has_value());
    latest = nextFrame(*client);
    EXPECT_EQ(member(latest, "sequence"), std::to_string(sequence + 1));
    seen += 1 + std::stoi(member(latest, "missed"));
  }
  EXPECT_EQ(seen, 10);
  EXPECT_LT(std::stoi(member(latest, "sequence")), 10) << "some were missed";
}

TEST(Stream, AViewerCannotGiveItselfMoreCreditThanItBeganWith) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kChain);
  const std::string stream =
      member(resultOf(client->request("stream.open", named(simulation, R"("what":"string","credits":2)"))), "stream");
  EXPECT_EQ(member(nextFrame(*client), "step"), "0");
  EXPECT_FALSE(client->notify("stream.ack", "{\"stream\":\"" + stream + "\",\"credits\":1000}").has_value());
  resultOf(client->request("simulation.step", named(simulation, R"("steps":10)")));
  EXPECT_EQ(member(nextFrame(*client), "step"), "1");
  EXPECT_EQ(member(nextFrame(*client), "step"), "2");
  // the turn of the last step has ended: its state was handed over to the viewers
  resultOf(client->request("simulation.get", named(simulation, R"("what":"statistics")")));
  EXPECT_FALSE(client->notify("stream.ack", "{\"stream\":\"" + stream + "\",\"sequence\":2}").has_value());
  const std::string latest = nextFrame(*client);
  EXPECT_EQ(member(latest, "step"), "10");
  EXPECT_EQ(member(latest, "missed"), "7");
}

TEST(Stream, AViewerThatDoesNotReadNeitherStopsTheSimulationNorFillsTheServer) {
  ServerOptions options;
  options.limits.outboxBytes = 400'000;
  const RunningServer server(options);
  const auto controller = connectTo(server);
  // 20,000 modules a frame: far more than the connection and the outbox hold
  const std::string simulation =
      create(*controller,
             "Lsystem: 1\nderivation length: 300\nAxiom: X(20000)A\n"
             "X(n) : n > 0 --> X(n - 1)\nA --> AFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFF"
             "FFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFF\nendlsystem\n");
  RawPeer viewer(server);
  (void)viewer.ask(kHello);
  const std::string opened = viewer.ask(R"({"jsonrpc":"2.0","id":2,"method":"stream.open","params":{"simulation":")" +
                                        simulation + R"(","what":"string"}})");
  EXPECT_EQ(member(opened, "id"), "2");
  EXPECT_EQ(member(resultOf(controller->request("simulation.run", named(simulation))), "step"), "300");
  // when it reads at last, it ends at the latest step without having been closed
  std::string frame;
  std::uint64_t frames = 0;
  std::uint64_t missed = 0;
  while (member(member(frame, "params"), "step") != "300") {
    frame = viewer.line();
    ASSERT_NE(frame, "(closed)");
    ASSERT_NE(frame, "(timeout)");
    if (member(frame, "method") == "stream.data") {
      EXPECT_EQ(member(member(frame, "params"), "sequence"), std::to_string(frames++));
      missed += std::stoull(member(member(frame, "params"), "missed"));
    }
  }
  EXPECT_EQ(member(member(frame, "params"), "finished"), "true");
  // each of the steps 0 to 300 was shown or is counted as missed
  EXPECT_EQ(frames + missed, 301U);
  EXPECT_GT(missed, 0U);
}

TEST(Stream, EndsWithAReasonWhenTheSimulationIsDeleted) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kChain);
  resultOf(client->request("stream.open", named(simulation, R"("what":"string")")));
  resultOf(client->request("simulation.delete", named(simulation)));
  std::string method;
  std::string reason;
  while (method != "stream.end") {
    const auto notification = client->nextNotification(std::chrono::seconds(30));
    ASSERT_TRUE(notification.has_value());
    method = notification->method;
    reason = member(notification->paramsJson, "reason");
  }
  EXPECT_EQ(reason, "the simulation was deleted");
}

TEST(Stream, ClosedStreamsAreSilentAndUnknownOnesAnError) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kChain);
  const std::string stream =
      member(resultOf(client->request("stream.open", named(simulation, R"("what":"string")"))), "stream");
  (void)nextFrame(*client);
  resultOf(client->request("stream.close", "{\"stream\":\"" + stream + "\"}"));
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_FALSE(client->nextNotification(std::chrono::milliseconds(0)).has_value());
  EXPECT_EQ(static_cast<int>(errorOf(client->request("stream.close", "{\"stream\":\"" + stream + "\"}")).code), 1011);
}

TEST(Stream, MoreThanTheSessionMayHaveIsALimit) {
  ServerOptions options;
  options.limits.streamsPerSession = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kChain);
  resultOf(client->request("stream.open", named(simulation, R"("what":"string")")));
  EXPECT_EQ(member(errorOf(client->request("stream.open", named(simulation, R"("what":"string")"))).data, "limit"),
            "streamsPerSession");
}

/// 3,000 segments that stay, and a branch that grows before them.
std::string bigModel() {
  std::string axiom = "Axiom: [A]";
  for (int i = 0; i < 3000; ++i) {
    axiom += "F(" + std::to_string(1 + i % 7) + ")+(1)";
  }
  return "Lsystem: 1\nderivation length: 20\n" + axiom + "\nA --> F(2)A\nendlsystem\n";
}

TEST(Stream, ADifferenceCostsWhatChanged) {
  const RunningServer server;
  const auto client = connectTo(server);
  for (const std::string what : {"turtle", "string"}) {
    const std::string simulation = create(*client, bigModel());
    resultOf(client->request("stream.open", named(simulation, R"("delta":true,"what":")" + what + "\"")));
    const std::string first = nextFrame(*client);
    EXPECT_EQ(member(first, "key"), "true");
    EXPECT_GT(first.size(), 15'000U);
    for (int step = 1; step <= 3; ++step) {
      resultOf(client->request("simulation.step", named(simulation)));
      const std::string frame = nextFrame(*client);
      EXPECT_EQ(member(frame, "key"), "false") << frame.substr(0, 300);
      EXPECT_LT(frame.size(), 800U) << frame;
    }
  }
}

TEST(Stream, GeometryAsColumnsNeedsNoBlocksAndTellsWhatWasDrawnNew) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client,
                                        "Lsystem: 1\nderivation length: 9\nAxiom: [G(2)]F(1)F(1)F(1)A\nA --> "
                                        "F(0.5)[{.f(1)+(120).f(1)+(120).}]A\nendlsystem\n");
  const auto shown = [&](std::string_view more) {
    resultOf(client->request("stream.open",
                             named(simulation, R"("what":"geometry","format":"columns")" + std::string(more))));
    return member(nextFrame(*client), "geometry");
  };
  const std::string whole = shown({});
  EXPECT_EQ(member(whole, "form"), "whole");
  EXPECT_EQ(member(whole, "segmentStart"), "[[0,0,0],[0,0,0],[0,1,0],[0,2,0]]");
  EXPECT_EQ(member(whole, "segmentModule"), "[1,3,4,5]");
  EXPECT_EQ(member(shown(R"(,"select":{"symbols":["G"]})"), "segmentEnd"), "[[0,2,0]]");
  EXPECT_EQ(member(shown(R"(,"select":{"plants":[1]})"), "segmentEnd"), "[]");
  resultOf(client->request("simulation.step", named(simulation)));
  for (int i = 0; i < 3; ++i) {
    (void)nextFrame(*client);
  }

  (void)shown(R"(,"delta":true)");
  resultOf(client->request("simulation.step", named(simulation)));
  std::string frame = nextFrame(*client);
  while (member(frame, "key") == "true") {
    frame = nextFrame(*client);
  }
  const std::string change = member(frame, "geometry");
  EXPECT_EQ(member(change, "form"), "difference");
  EXPECT_EQ(member(change, "segmentRuns"), "[[0,5,0],[4294967295,1,0]]");
  EXPECT_EQ(member(change, "segmentEnd"), "[[0,4,0]]");
  EXPECT_EQ(member(change, "organPlant"), "[0]");
}

TEST(Stream, GeometryOfNothingIsNoDifference) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, "Lsystem: 1\nderivation length: 9\nAxiom: A\nA --> A\nendlsystem\n");
  resultOf(client->request("stream.open", named(simulation, R"("what":"geometry","format":"columns","delta":true)")));
  (void)nextFrame(*client);
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(member(nextFrame(*client), "key"), "true");
}

TEST(Stream, ThoseThatEndedTakeNoRoom) {
  ServerOptions options;
  options.limits.streamsPerSession = 2;
  const RunningServer server(options);
  const auto client = connectTo(server);
  for (int i = 0; i < 5; ++i) {
    const std::string simulation = create(*client, kChain);
    resultOf(client->request("stream.open", named(simulation, R"("what":"string")")));
    resultOf(client->request("simulation.delete", named(simulation)));
  }
}

TEST(Stream, AfterMissedFramesComesAKeyFrame) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, bigModel());
  const std::string stream =
      member(resultOf(client->request("stream.open", named(simulation, R"("delta":true,"what":"turtle","credits":2)"))),
             "stream");
  (void)nextFrame(*client);
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(member(nextFrame(*client), "key"), "false");
  // there is no credit left; only the last of the three can come after the credit for it
  resultOf(client->request("simulation.step", named(simulation, R"("steps":3)")));
  // the last one is handed over after the answer, and before the next turn
  resultOf(client->request("simulation.get", named(simulation, R"("what":"statistics")")));
  EXPECT_FALSE(client->notify("stream.ack", "{\"stream\":\"" + stream + "\",\"sequence\":1}").has_value());
  const std::string latest = nextFrame(*client);
  EXPECT_EQ(member(latest, "step"), "4");
  EXPECT_EQ(member(latest, "missed"), "2");
  EXPECT_EQ(member(latest, "key"), "true");
}

TEST(Stream, BeyondStreamBytesEveryFrameIsAKeyFrame) {
  for (const std::uint64_t bound : {std::uint64_t{0}, std::uint64_t{10'000'000}}) {
    ServerOptions options;
    options.limits.streamBytes = bound;
    const RunningServer server(options);
    const auto client = connectTo(server);
    const std::string simulation = create(*client, bigModel());
    resultOf(client->request("stream.open", named(simulation, R"("delta":true,"what":"turtle")")));
    resultOf(client->request("simulation.step", named(simulation, R"("steps":2)")));
    (void)nextFrame(*client);
    (void)nextFrame(*client);
    EXPECT_EQ(member(nextFrame(*client), "key"), bound == 0 ? "true" : "false");
    const std::string memory = member(resultOf(client->request("server.status", "{}")), "memory");
    EXPECT_EQ(member(memory, "streamBytes") == "0", bound == 0) << memory;
  }
}

TEST(Stream, MaxHzLeavesStepsOutAndShowsTheLatestInTheEnd) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kChain);
  resultOf(client->request("stream.open", named(simulation, R"("what":"string","maxHz":5)")));
  EXPECT_EQ(member(nextFrame(*client), "step"), "0");
  for (int step = 0; step < 20; ++step) {
    resultOf(client->request("simulation.step", named(simulation)));
  }
  // one for each fifth of a second that this took, and one of the end; nothing counts as missed
  std::string frame;
  int count = 0;
  do {
    frame = nextFrame(*client);
    EXPECT_EQ(member(frame, "missed"), "0");
    ++count;
  } while (member(frame, "step") != "20");
  EXPECT_LT(count, 20);
}

TEST(Stream, SinglePrecisionRoundsTextToo) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, "Lsystem: 1\nAxiom: F(0.1)+(30)F(1)\nZ --> Z\nendlsystem\n");
  for (const std::string precision : {"double", "single"}) {
    resultOf(client->request("stream.open", named(simulation, R"("what":"turtle","precision":")" + precision + "\"")));
    const std::string frame = nextFrame(*client);
    EXPECT_EQ(frame.find("0.8660254037844387") == std::string::npos, precision == "single") << frame;
    EXPECT_EQ(frame.find("0.8660254,") == std::string::npos, precision == "double") << frame;
  }
}

TEST(Stream, WrongParametersNameTheirPath) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kChain);
  for (const auto& [more, message] : {
           std::pair(R"("what":"scent")",
                     "params.what: expected one of turtle, string, statistics, geometry, queries, found \"scent\""),
           std::pair(R"("what":"string","maxHz":0)",
                     "params.maxHz: expected a number of frames a second from 0.001 to 1000, found 0"),
           std::pair(R"("what":"string","maxHz":1001)",
                     "params.maxHz: expected a number of frames a second from 0.001 to 1000, found 1001"),
           std::pair(R"("what":"string","delta":1)", "params.delta: expected true or false, found 1"),
           std::pair(R"("what":"geometry","format":"obj")",
                     "params.format: expected one of glb, columns, found \"obj\""),
           std::pair(R"("what":"geometry")",
                     "params.bin: geometry as a file comes in binary blocks; say \"bin\": true, or \"format\": "
                     "\"columns\" for tables"),
       }) {
    EXPECT_EQ(errorOf(client->request("stream.open", named(simulation, more))).message, message);
  }
}

}  // namespace
}  // namespace espalier::server::stream_test

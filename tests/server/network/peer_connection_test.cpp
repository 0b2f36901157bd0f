#include <gtest/gtest.h>

#include <string>

#include "protocol/json_text.h"
#include "tests/server/raw_peer.h"
#include "tests/server/server_fixture.h"

namespace espalier::server {
namespace {

TEST(PeerConnection, AnswersThatNobodyReadsYetComeWholeAndInTheirOrder) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string string(30'000, 'A');
  const std::string simulation =
      create(*client, "Lsystem: 1\nderivation length: 9\nAxiom: " + string + "\nA --> AA\nendlsystem\n");
  RawPeer peer(server);
  (void)peer.ask(kHello);
  // more than the system takes at once, of messages that it takes in part; each asked alone
  constexpr int kCount = 400;
  for (int id = 1; id <= kCount; ++id) {
    peer.send(R"({"jsonrpc":"2.0","id":)" + std::to_string(id) + R"(,"method":"simulation.get","params":)" +
              named(simulation, R"("what":"string")") + "}\n");
  }
  for (int id = 1; id <= kCount; ++id) {
    const std::string line = peer.line();
    // not ASSERT_EQ, which prints both
    ASSERT_TRUE(line == R"({"jsonrpc":"2.0","id":)" + std::to_string(id) + R"(,"result":{"step":0,"string":")" +
                            string + "\"}}")
        << id << ": " << line.size() << " bytes, " << line.substr(0, 60);
  }
}

TEST(PeerConnection, WhoSendsNoMoreIsAnsweredWhatItHasAsked) {
  const RunningServer server;
  RawPeer peer(server);
  (void)peer.ask(kHello);
  const std::string created = peer.ask(R"({"jsonrpc":"2.0","id":2,"method":"simulation.create","params":)" +
                                       createParams(kGrowth, R"([{"type":"height"}])") + "}");
  const std::string simulation = member(protocol::memberOf(created, "result").value_or("{}"), "simulation");
  std::string lines;
  for (int id = 3; id < 9; ++id) {
    lines += R"({"jsonrpc":"2.0","id":)" + std::to_string(id) + R"(,"method":"simulation.step","params":)" +
             named(simulation) + "}\n";
  }
  peer.send(lines);
  peer.endSending();
  for (int id = 3; id < 9; ++id) {
    const std::string answer = peer.line();
    EXPECT_EQ(protocol::memberOf(answer, "id"), std::to_string(id)) << answer;
    EXPECT_EQ(member(protocol::memberOf(answer, "result").value_or("{}"), "step"), std::to_string(id - 2)) << answer;
  }
  EXPECT_EQ(peer.line(), "(closed)");
}

}  // namespace
}  // namespace espalier::server

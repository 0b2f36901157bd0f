#include <gtest/gtest.h>

#include <string>

#include "raw_peer.h"
#include "server_fixture.h"

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

}  // namespace
}  // namespace espalier::server

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <latch>
#include <string>
#include <thread>
#include <vector>

#include "protocol/json_text.h"
#include "tests/server/raw_peer.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::peer_connection_test {
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

std::string limitOf(const std::string& line) {
  return member(member(protocol::memberOf(line, "error").value_or("{}"), "data"), "limit");
}

/// A request of so many bytes, its end not counted.
std::string statusOf(std::size_t bytes) {
  const std::string begin = R"({"jsonrpc":"2.0","id":7,"method":"server.status","params":{"x":")";
  return begin + std::string(bytes - begin.size() - 3, 'x') + "\"}}";
}

TEST(PeerConnection, BeforeHelloALineIsShort) {
  const RunningServer server;
  RawPeer stranger(server);
  // hello is missing, and the session goes on
  EXPECT_EQ(member(protocol::memberOf(stranger.ask(statusOf(65'536)), "error").value_or("{}"), "code"), "1012");
  EXPECT_EQ(limitOf(stranger.ask(statusOf(65'537))), "lineBytes");
  EXPECT_TRUE(stranger.isClosed());
  // the same for a line that never ends
  RawPeer endless(server);
  endless.send(std::string(65'537, 'x'));
  EXPECT_EQ(limitOf(endless.line()), "lineBytes");
  EXPECT_TRUE(endless.isClosed());
  // after hello, also for what is sent together with it
  RawPeer client(server);
  client.send(std::string(kHello) + "\n" + statusOf(1'000'000) + "\n");
  EXPECT_EQ(member(client.line(), "id"), "1");
  const std::string answer = client.line();
  EXPECT_EQ(member(answer, "id"), "7") << answer;
}

/// The gauge of the page /metrics.
std::uint64_t decodingBytes(const RunningServer& server) {
  RawPeer browser(server.httpAddress());
  browser.send("GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  constexpr std::string_view kName = "espalier_decoding_bytes ";
  for (std::string line = browser.line(); line != "(closed)" && line != "(timeout)"; line = browser.line()) {
    if (line.starts_with(kName)) {
      return std::stoull(line.substr(kName.size()));
    }
  }
  return 0;
}

TEST(PeerConnection, BytesThatWaitToBeDecodedAreBoundedForAllPeersTogether) {
  ServerOptions options;
  options.httpHost = "127.0.0.1";
  options.limits.decodingBytes = 3'000'000;
  const RunningServer server(options);
  RawPeer first(server);
  RawPeer second(server);
  (void)first.ask(kHello);
  (void)second.ask(kHello);
  // a line that does not end, from each
  first.send(std::string(2'000'000, 'x'));
  while (decodingBytes(server) < 2'000'000) {
    std::this_thread::yield();
  }
  second.send(std::string(2'000'000, 'x'));
  EXPECT_EQ(limitOf(second.line()), "decodingBytes");
  EXPECT_TRUE(second.isClosed());
  // the other goes on, and there is room again
  EXPECT_EQ(member(protocol::memberOf(first.ask(""), "error").value_or("{}"), "code"), "-32700");
  // an answer may come before the bytes of its question are given back
  while (decodingBytes(server) > 0) {
    std::this_thread::yield();
  }
  RawPeer third(server);
  (void)third.ask(kHello);
  // the room that a long message gets for its next read counts, too
  EXPECT_EQ(member(third.ask(statusOf(2'700'000)), "id"), "7");
  while (decodingBytes(server) > 0) {
    std::this_thread::yield();
  }
}

TEST(PeerConnection, AnotherPeerIsAnsweredWhileABigMessageIsDecoded) {
  const RunningServer server;
  RawPeer big(server);
  (void)big.ask(kHello);
  // a million small objects in a line of 17 MB, which takes long to decode
  std::string line = R"({"jsonrpc":"2.0","id":7,"method":"server.status","params":{"x":[)";
  for (int i = 0; i < 1'000'000; ++i) {
    line += R"({"a":[1,2],"b":2},)";
  }
  line += "0]}}\n";
  const auto client = connectTo(server);
  std::atomic<bool> isAnswered{false};
  std::thread sender([&] {
    big.send(line);
    EXPECT_EQ(member(big.line(), "id"), "7");
    isAnswered = true;
  });
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  Clock::duration longest{};
  while (!isAnswered) {
    const auto before = Clock::now();
    resultOf(client->request("ping", "{}"));
    longest = std::max(longest, Clock::now() - before);
  }
  EXPECT_LT(longest, (Clock::now() - begin) / 3);
  sender.join();
}

TEST(PeerConnection, SilentConnectionsNeverLockOutAClientThatSaysHello) {
  ServerOptions options;
  options.httpHost = "127.0.0.1";
  options.limits.waitingConnections = 10;
  options.limits.sessions = 5;
  const RunningServer server(options);
  std::vector<std::unique_ptr<RawPeer>> silent;
  for (int i = 0; i < 60; ++i) {
    silent.push_back(std::make_unique<RawPeer>(i % 2 == 0 ? server.address() : server.httpAddress()));
  }
  std::vector<std::unique_ptr<client::Client>> clients;
  for (int i = 0; i < 5; ++i) {
    clients.push_back(connectTo(server));
    ASSERT_NE(clients.back(), nullptr);
  }
  // the oldest of both sides are closed long before their deadline
  EXPECT_TRUE(silent[0]->isClosed());
  EXPECT_TRUE(silent[1]->isClosed());
  EXPECT_EQ(member(resultOf(clients[0]->request("server.status", "{}")), "sessions"), "5");
}

}  // namespace
}  // namespace espalier::server::peer_connection_test

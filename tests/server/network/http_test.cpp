#include "server/network/http.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/raw_peer.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::http_test {
namespace {

constexpr std::string_view kRequest = "GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n";

ServerOptions withHttp(std::uint32_t handshakeMilliseconds) {
  ServerOptions options;
  options.httpHost = "127.0.0.1";
  options.limits.handshakeMilliseconds = handshakeMilliseconds;
  return options;
}

/// Reads until a line begins with the text.
bool hasLine(RawPeer& peer, std::string_view begin) {
  std::string line = peer.line();
  while (line != "(closed)" && line != "(timeout)" && !line.starts_with(begin)) {
    line = peer.line();
  }
  return line.starts_with(begin);
}

TEST(Http, ConnectionsThatCloseWhenTheirTimeIsOverHarmNothing) {
  // the timer of a connection used its stream after the connection had ended
  const RunningServer server(withHttp(20));
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&server, thread] {
      for (int i = 0; i < 50; ++i) {
        RawPeer peer(server.httpAddress());
        peer.send("GET / HT");
        std::this_thread::sleep_for(std::chrono::microseconds(19'000 + 100 * ((i + 13 * thread) % 20)));
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  RawPeer peer(server.httpAddress());
  peer.send(kRequest);
  EXPECT_EQ(peer.line(), "HTTP/1.1 200 OK");
}

TEST(Http, ARequestThatDoesNotComeInTimeEndsTheConnection) {
  const RunningServer server(withHttp(50));
  RawPeer silent(server.httpAddress());
  RawPeer slow(server.httpAddress());
  slow.send("GET /health HTTP/1.1\r\nHost: loc");
  EXPECT_TRUE(silent.isClosed());
  EXPECT_TRUE(slow.isClosed());
}

TEST(Http, AWebSocketThatSaysNoHelloIsClosedInTime) {
  const RunningServer server(withHttp(200));
  RawPeer silent(server.httpAddress());
  silent.send(
      "GET /espalier/1 HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
  EXPECT_EQ(silent.line(), "HTTP/1.1 101 Switching Protocols");
  EXPECT_TRUE(silent.isClosed());
}

TEST(Http, AConnectionIsKeptForMoreRequestsAndNotForEver) {
  const RunningServer server(withHttp(10'000));
  RawPeer peer(server.httpAddress());
  for (int i = 0; i < 999; ++i) {
    peer.send(kRequest);
    ASSERT_TRUE(hasLine(peer, "HTTP/1.1 200")) << i;
  }
  peer.send(kRequest);
  EXPECT_TRUE(hasLine(peer, "Connection: close"));
  EXPECT_TRUE(peer.isClosed());
}

TEST(Http, DownloadsThatNobodyReadsCountForTheAccount) {
  ServerOptions options = withHttp(10'000);
  options.limits.memoryBytes = 150'000'000;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation =
      create(*client, "Lsystem: 1\nderivation length: 40\nAxiom: A(1)\nA(x) --> A(x)A(x)\nendlsystem\n");
  // a snapshot of ten megabytes, more than the system takes for a peer that does not read
  resultOf(client->request("simulation.step", named(simulation, R"("steps":20)")));
  const std::string request = "GET /simulations/" + simulation + "/plant.snapshot HTTP/1.1\r\nHost: localhost\r\n\r\n";
  std::vector<std::unique_ptr<RawPeer>> peers;
  bool isRefused = false;
  while (!isRefused && peers.size() < 30) {
    peers.push_back(std::make_unique<RawPeer>(server.httpAddress()));
    peers.back()->send(request);
    isRefused = peers.back()->line() == "HTTP/1.1 503 Service Unavailable";
  }
  EXPECT_TRUE(isRefused);
  EXPECT_GT(peers.size(), 3U);
  peers.clear();
  while (std::stoull(member(member(resultOf(client->request("server.status", "{}")), "memory"), "frameBytes")) > 0) {
    std::this_thread::yield();
  }
  RawPeer reader(server.httpAddress());
  reader.send(request);
  EXPECT_EQ(reader.line(), "HTTP/1.1 200 OK");
}

TEST(Http, ARequestWithABodyOrTooLongIsAnsweredAndEndsTheConnection) {
  const RunningServer server(withHttp(10'000));
  for (const std::string head : {"POST /health HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nhello",
                                 "GET /health HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"}) {
    RawPeer peer(server.httpAddress());
    peer.send(head);
    EXPECT_EQ(peer.line(), "HTTP/1.1 413 Payload Too Large") << head;
    EXPECT_TRUE(peer.isClosed());
  }
  RawPeer peer(server.httpAddress());
  peer.send("GET /" + std::string(20'000, 'x') + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(peer.line(), "HTTP/1.1 431 Request Header Fields Too Large");
}

TEST(Http, APeerThatLeavesGivesItsDownloadUp) {
  const RunningServer server(withHttp(5'000));
  const auto controller = connectTo(server);
  std::atomic<bool> isAsked{false};
  std::atomic<bool> isReleased{false};
  const OfferingEnvironment environment(
      server, "slow", [&](client::Client& self, const client::IncomingRequest& request) {
        if (request.method != "environment.step") {
          (void)self.respondError(request.id, {protocol::ErrorCode::UnknownMethod, "no", {}});
          return;
        }
        isAsked = true;
        isAsked.notify_all();
        isReleased.wait(false);
        (void)self.respond(request.id, R"({"replies":[{"id":0,"parameters":[1]}]})");
      });
  const std::string simulation = create(*controller, kGrowth, R"([{"type":"offered","name":"slow"}])");
  const auto step = controller->send("simulation.step", named(simulation)).value();
  isAsked.wait(false);
  // the simulation has no turn for it before the environment answers
  RawPeer peer(server.httpAddress());
  peer.send("GET /simulations/" + simulation + "/plant.obj HTTP/1.1\r\nHost: localhost\r\n\r\n");
  peer.endSending();
  EXPECT_EQ(peer.line(), "(closed)");
  isReleased = true;
  isReleased.notify_all();
  resultOf(controller->waitFor(step, std::chrono::seconds(30)));
}

}  // namespace
}  // namespace espalier::server::http_test

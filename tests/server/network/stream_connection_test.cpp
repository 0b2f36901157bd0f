#include "server/network/stream_connection.h"

#include <gtest/gtest.h>

#include <sys/socket.h>

#include <memory>
#include <string>

#include "server/session/session.h"

namespace espalier::server::stream_connection_test {
namespace {

using UnixSocket = asio::local::stream_protocol::socket;

/// Connections of a server whose network thread is the test's own, so it sees what is handled in which order.
class ConnectionsByHand : public ::testing::Test {
 protected:
  /// A connection, and the socket of its peer.
  struct Connected {
    std::shared_ptr<StreamConnection<UnixSocket>> connection;
    std::unique_ptr<UnixSocket> peer;

    void send(const std::string& bytes) const { asio::write(*peer, asio::buffer(bytes)); }
    [[nodiscard]] std::size_t available() const { return peer->available(); }
  };

  Connected connect() {
    UnixSocket ours(context_);
    auto theirs = std::make_unique<UnixSocket>(context_);
    asio::local::connect_pair(ours, *theirs);
    theirs->set_option(asio::socket_base::send_buffer_size(1'000'000));
    Connected made{std::make_shared<StreamConnection<UnixSocket>>(
                       std::move(ours), core_,
                       Accepted{"unix", std::chrono::steady_clock::now() + std::chrono::hours(1),
                                admission_.enter(Side::Protocol, {})}),
                   std::move(theirs)};
    made.connection->start(std::make_shared<Session>(std::to_string(++count_), core_, made.connection));
    return made;
  }

  static ServerOptions silent() {
    ServerOptions options;
    options.logLevel = "off";
    return options;
  }

  ServerCore core_{silent()};
  Admission admission_;
  asio::io_context context_{1};
  int count_ = 0;
};

constexpr const char* kGreeting =
    R"({"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1],"roles":["viewer"]}})";

TEST_F(ConnectionsByHand, AFloodOfMessagesOfOnePeerLetsAnotherBetween) {
  admission_.setBounds({.sessions = 10, .waiting = 10, .perAddress = 0});
  // no second system call is needed for the flood
  constexpr std::uint64_t kFlood = 3'000;
  std::string flood = std::string(kGreeting) + "\n";
  for (std::uint64_t i = 0; i < kFlood; ++i) {
    flood += R"({"jsonrpc":"2.0","id":2,"method":"ping"})"
             "\n";
  }
  ASSERT_LT(flood.size(), 200'000U);
  const Connected flooding = connect();
  const Connected other = connect();
  flooding.send(flood);
  other.send(std::string(kGreeting) + "\n" +
             R"({"jsonrpc":"2.0","id":2,"method":"ping"})"
             "\n");
  while (other.available() == 0 && context_.run_one() > 0) {
  }
  // the other one is answered, and most of the flood still waits
  EXPECT_GT(other.available(), 0U);
  EXPECT_LT(core_.metrics.requests, kFlood / 2);
  while (core_.metrics.requests < kFlood + 3 && context_.run_one() > 0) {
  }
  EXPECT_EQ(core_.metrics.requests, kFlood + 3);
  flooding.connection->closeNow();
  other.connection->closeNow();
  context_.poll();
}

}  // namespace
}  // namespace espalier::server::stream_connection_test

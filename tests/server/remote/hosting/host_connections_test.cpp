#include "server/remote/hosting/host_connections.h"

#include <gtest/gtest.h>

namespace espalier::server::host_connections_test {
namespace {

using Socket = HostConnections::Socket;

class Connections : public ::testing::Test {
 protected:
  Socket socket() {
    auto made = std::make_shared<boost::asio::ip::tcp::socket>(context_);
    made->open(boost::asio::ip::tcp::v4());
    return made;
  }
  // whether it has been closed, as the one that gave way is
  bool isClosed(const Socket& socket) {
    context_.restart();
    context_.poll();
    return !socket->is_open();
  }

  boost::asio::io_context context_;
};

TEST_F(Connections, TheLongestSilentGivesWayThenTheLongestIdle) {
  HostConnections connections(3, 3);
  const Socket idle = socket();
  const Socket busy = socket();
  const Socket silent = socket();
  for (const Socket& each : {idle, busy, silent}) {
    ASSERT_TRUE(connections.enter(each));
  }
  EXPECT_TRUE(connections.begin(idle));
  EXPECT_FALSE(connections.begin(idle));
  connections.end(idle, false);
  EXPECT_TRUE(connections.begin(busy));
  connections.end(busy, true);
  const Socket fourth = socket();
  EXPECT_TRUE(connections.enter(fourth));
  EXPECT_TRUE(isClosed(silent));
  EXPECT_TRUE(connections.begin(fourth));
  EXPECT_TRUE(connections.enter(socket()));
  EXPECT_TRUE(isClosed(idle));
  EXPECT_FALSE(isClosed(busy));
}

TEST_F(Connections, WhatIsAnsweredNeverGivesWay) {
  HostConnections connections(1, 1);
  const Socket first = socket();
  ASSERT_TRUE(connections.enter(first));
  EXPECT_TRUE(connections.begin(first));
  // the time of silence ends while its first message is answered
  EXPECT_FALSE(connections.leaveSilent(first));
  EXPECT_FALSE(connections.enter(socket()));
  EXPECT_FALSE(connections.closeOne());
  EXPECT_FALSE(isClosed(first));
  connections.leave(first);
  EXPECT_TRUE(connections.enter(socket()));
}

TEST_F(Connections, OneThatStaysSilentLeaves) {
  HostConnections connections(1, 1);
  const Socket first = socket();
  ASSERT_TRUE(connections.enter(first));
  EXPECT_TRUE(connections.leaveSilent(first));
  EXPECT_FALSE(connections.leaveSilent(first));
  EXPECT_FALSE(connections.begin(first));
}

}  // namespace
}  // namespace espalier::server::host_connections_test

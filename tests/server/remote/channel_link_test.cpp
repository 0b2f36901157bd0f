#include "server/remote/channel_link.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <thread>

#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "server/remote/processes/line_channel.h"

namespace espalier::server::channel_link_test {
namespace {

using namespace std::chrono_literals;

/// A socket of the file system that waits for peers.
class PeerSocket {
 public:
  PeerSocket()
      : path_((std::filesystem::path(testing::TempDir()) / ("channel_link_" + std::to_string(::getpid()))).string()),
        listening_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path_.c_str(), sizeof(address.sun_path) - 1);
    std::filesystem::remove(path_);
    EXPECT_EQ(::bind(listening_.number(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    EXPECT_EQ(::listen(listening_.number(), 4), 0);
  }
  ~PeerSocket() { std::filesystem::remove(path_); }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] Descriptor acceptDescriptor() const {
    return Descriptor(::accept(listening_.number(), nullptr, nullptr));
  }
  [[nodiscard]] std::unique_ptr<LineChannel> accept() const {
    return std::make_unique<LineChannel>(acceptDescriptor(), Descriptor(), 1'000'000);
  }
  /// Ends an accept() that waits.
  void close() const { ::shutdown(listening_.number(), SHUT_RDWR); }

 private:
  std::string path_;
  Descriptor listening_;
};

Deadline soon() {
  return std::chrono::steady_clock::now() + 30s;
}

/// The id of the next question to the peer; empty: there is none.
std::string nextQuestion(LineChannel& channel) {
  std::string line;
  return channel.readLine(line, soon()) == LineChannel::Status::Done ? protocol::memberOf(line, "id").value_or("") : "";
}

void answer(LineChannel& channel, const std::string& id, const std::string& result) {
  (void)channel.write(R"({"jsonrpc":"2.0","id":")" + id + R"(","result":)" + result + "}\n", soon());
}

/// A link that waits for its peer.
std::unique_ptr<ChannelLink> linkTo(const PeerSocket& socket, bool offersBlocks = true) {
  ChannelOptions options;
  options.introductionTimeout = 30s;
  options.offersBlocks = offersBlocks;
  return ChannelLink::unixSocket(socket.path(), options);
}

/// Answers hello. This peer takes blocks.
void greet(LineChannel& channel) {
  answer(channel, nextQuestion(channel),
         R"({"protocol":1,"session":"1","server":"peer","roles":[],"capabilities":["bin"],"limits":{}})");
}

TEST(ChannelLink, AConnectionThatHasHalfAMessageIsNotUsedAgain) {
  const PeerSocket socket;
  const auto link = linkTo(socket);
  std::thread peer([&socket] {
    const auto first = socket.accept();
    greet(*first);
    // the first connection stays open, and nobody reads from it
    const auto second = socket.accept();
    greet(*second);
  });
  EXPECT_FALSE(link->connect().has_value());
  EXPECT_EQ(link->generation(), 1U);
  const auto outcome = link->call("environment.step", R"({"a":")" + std::string(8'000'000, 'x') + "\"}", 100ms);
  ASSERT_FALSE(outcome.has_value());
  EXPECT_EQ(outcome.error().kind, LinkFailure::Kind::Timeout);
  EXPECT_EQ(link->generation(), 0U);
  EXPECT_FALSE(link->connect().has_value());
  EXPECT_EQ(link->generation(), 2U);
  socket.close();
  peer.join();
}

TEST(ChannelLink, AConnectionThatHasHalfAnAnswerIsNotUsedAgain) {
  const PeerSocket socket;
  ChannelOptions options;
  options.introductionTimeout = 300ms;
  const auto link = ChannelLink::unixSocket(socket.path(), options);
  std::thread peer([&socket] {
    const std::string question = R"({"jsonrpc":"2.0","id":1,"method":"ping"})"
                                 "\n";
    for (int i = 0; i < 2; ++i) {
      // it asks all the time and reads nothing
      const Descriptor connection = socket.acceptDescriptor();
      while (::send(connection.number(), question.data(), question.size(), MSG_NOSIGNAL) > 0) {
      }
    }
  });
  const auto failure = link->connect();
  EXPECT_EQ(failure ? failure->kind : LinkFailure::Kind::Away, LinkFailure::Kind::Timeout);
  EXPECT_EQ(link->generation(), 0U);
  const auto outcome = link->call("environment.step", "{}", 300ms);
  EXPECT_EQ(outcome ? LinkFailure::Kind::Away : outcome.error().kind, LinkFailure::Kind::Timeout);
  EXPECT_EQ(link->generation(), 0U);
  socket.close();
  peer.join();
}

TEST(ChannelLink, BlocksNeedBothSides) {
  const PeerSocket socket;
  for (const bool offersBlocks : {true, false}) {
    const auto link = linkTo(socket, offersBlocks);
    std::thread peer([&socket] { greet(*socket.accept()); });
    EXPECT_FALSE(link->connect().has_value());
    EXPECT_EQ(link->terms().takesBlocks, offersBlocks);
    peer.join();
  }
}

TEST(ChannelLink, AServerIsNoEnvironment) {
  const PeerSocket socket;
  const std::string refusal = R"("error":{"code":1003,"message":"This server asks for a token."})";
  for (const std::string& greeting : {std::string(R"("result":{"protocol":1,"roles":["controller"]})"), refusal}) {
    const auto link = linkTo(socket);
    std::thread peer([&socket, &greeting] {
      const auto channel = socket.accept();
      const std::string id = nextQuestion(*channel);
      (void)channel->write(R"({"jsonrpc":"2.0","id":")" + id + "\"," + greeting + "}\n", soon());
    });
    const auto failure = link->connect();
    peer.join();
    ASSERT_TRUE(failure.has_value()) << greeting;
    EXPECT_EQ(failure->kind, LinkFailure::Kind::Server);
    EXPECT_EQ(failure->message, "is a server of simulations, not an environment");
    EXPECT_EQ(link->generation(), 0U);
  }
}

TEST(ChannelLink, AnEnvironmentMayNameItsOwnRole) {
  const PeerSocket socket;
  const auto link = linkTo(socket);
  std::thread peer([&socket] {
    const auto channel = socket.accept();
    const std::string id = nextQuestion(*channel);
    (void)channel->write(
        R"({"jsonrpc":"2.0","id":")" + id + R"(","result":{"protocol":1,"roles":["environment"]}})" + "\n", soon());
  });
  EXPECT_FALSE(link->connect().has_value());
  peer.join();
}

TEST(ChannelLink, AnAnswerThatComesTooLateIsNotTakenForTheNextOne) {
  const PeerSocket socket;
  const auto link = linkTo(socket);
  std::thread peer([&socket] {
    const auto channel = socket.accept();
    greet(*channel);
    const std::string first = nextQuestion(*channel);
    const std::string second = nextQuestion(*channel);
    answer(*channel, first, R"({"state":"b25l"})");
    answer(*channel, second, R"({"state":"dHdv"})");
  });
  EXPECT_EQ(link->call("environment.save", "{}", 100ms).error().kind, LinkFailure::Kind::Timeout);
  // what was given up before does not end the next question
  link->interrupt();
  const auto outcome = link->call("environment.save", "{}", 30s);
  EXPECT_TRUE(outcome.has_value());
  if (outcome) {
    EXPECT_EQ(protocol::decodeSaveResult(*outcome).value(), "two");
  }
  socket.close();
  peer.join();
}

TEST(ChannelLink, APeerThatSendsOtherMessagesWithoutAnEndIsLate) {
  const PeerSocket socket;
  for (const char* other : {R"({"jsonrpc":"2.0","method":"note"})", R"({"jsonrpc":"2.0","id":"s0","result":{}})", ""}) {
    auto link = linkTo(socket);
    std::thread peer([&socket, other] {
      const auto channel = socket.accept();
      greet(*channel);
      std::string flood;
      while (flood.size() < 100'000) {
        flood += std::string(other) + "\n";
      }
      while (channel->write(flood, soon()) == LineChannel::Status::Done) {
      }
    });
    const auto outcome = link->call("environment.step", "{}", 100ms);
    EXPECT_FALSE(outcome.has_value());
    if (!outcome) {
      EXPECT_EQ(outcome.error().kind, LinkFailure::Kind::Timeout) << other;
      EXPECT_EQ(outcome.error().message, "did not answer within 100 ms");
    }
    link.reset();
    peer.join();
  }
}

}  // namespace
}  // namespace espalier::server::channel_link_test

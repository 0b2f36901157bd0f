#include "server/remote/processes/line_channel.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>

#include <array>
#include <memory>
#include <thread>

namespace espalier::server::line_channel_test {
namespace {

using Status = LineChannel::Status;

Deadline in(std::chrono::milliseconds time) {
  return std::chrono::steady_clock::now() + time;
}

struct Pair {
  Pair() : Pair(descriptors()) {}
  explicit Pair(std::array<int, 2> ends)
      : a(Descriptor(ends[0]), Descriptor(), 1'000'000),
        b(std::make_unique<LineChannel>(Descriptor(ends[1]), Descriptor(), 1'000'000)) {}
  static std::array<int, 2> descriptors() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    return ends;
  }
  LineChannel a;
  std::unique_ptr<LineChannel> b;
};

TEST(LineChannel, LinesCrossAndALateOneIsATimeout) {
  Pair pair;
  std::string line;
  EXPECT_EQ(pair.a.write("one\ntwo\n", in(std::chrono::seconds(5))), Status::Done);
  EXPECT_EQ(pair.b->readLine(line, in(std::chrono::seconds(5))), Status::Done);
  EXPECT_EQ(line, "one");
  EXPECT_EQ(pair.b->readLine(line, in(std::chrono::seconds(5))), Status::Done);
  EXPECT_EQ(line, "two");
  EXPECT_EQ(pair.b->readLine(line, in(std::chrono::milliseconds(1))), Status::Timeout);
}

TEST(LineChannel, TwoThatBothWriteMuchDoNotBlockEachOther) {
  Pair pair;
  const std::string much = std::string(900'000, 'x') + "\n";
  // each reads on after its own write, as a peer that answers does
  const auto exchange = [&much](LineChannel& channel) {
    std::string line;
    EXPECT_EQ(channel.write(much, in(std::chrono::seconds(30))), Status::Done);
    EXPECT_EQ(channel.readLine(line, in(std::chrono::seconds(30))), Status::Done);
    EXPECT_EQ(line.size(), 900'000U);
  };
  std::thread other([&] { exchange(*pair.b); });
  exchange(pair.a);
  other.join();
}

TEST(LineChannel, APeerThatIsGoneIsClosedAndRaisesNoSignal) {
  Pair pair;
  pair.b.reset();
  std::string line;
  EXPECT_EQ(pair.a.readLine(line, in(std::chrono::seconds(5))), Status::Closed);
  EXPECT_EQ(pair.a.write("x\n", in(std::chrono::seconds(5))), Status::Closed);
}

TEST(LineChannel, AnInterruptionEndsAWait) {
  Pair pair;
  std::thread interrupting([&] { pair.a.interrupt(); });
  std::string line;
  EXPECT_EQ(pair.a.readLine(line, in(std::chrono::seconds(30))), Status::Interrupted);
  interrupting.join();
}

TEST(LineChannel, ALineBeyondTheLimitIsAnOverflow) {
  const auto ends = Pair::descriptors();
  LineChannel narrow{Descriptor(ends[0]), Descriptor(), 10};
  LineChannel wide{Descriptor(ends[1]), Descriptor(), 1000};
  EXPECT_EQ(wide.write("01234567890123\n", in(std::chrono::seconds(5))), Status::Done);
  std::string line;
  EXPECT_EQ(narrow.readLine(line, in(std::chrono::seconds(5))), Status::Overflow);
}

/// A thread that writes the same bytes into a socket until the other end is closed.
class Flood {
 public:
  Flood(int descriptor, const std::string& bytes)
      : thread_([this, descriptor, bytes] {
          const Descriptor socket(descriptor);
          ssize_t count = 0;
          while ((count = ::send(socket.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL)) > 0) {
            sent_ += static_cast<std::size_t>(count);
          }
        }) {}
  /// How much the other end has taken. Only when that is closed.
  std::size_t end() {
    thread_.join();
    return sent_;
  }

 private:
  std::size_t sent_ = 0;
  std::thread thread_;
};

TEST(LineChannel, APeerThatSendsEmptyLinesWithoutAnEndIsLate) {
  const auto ends = Pair::descriptors();
  auto channel = std::make_unique<LineChannel>(Descriptor(ends[0]), Descriptor(), 1'000);
  Flood flood(ends[1], std::string(10'000, '\n'));
  std::string line;
  EXPECT_EQ(channel->readLine(line, in(std::chrono::milliseconds(100))), Status::Timeout);
  channel.reset();
  flood.end();
}

TEST(LineChannel, APeerThatSendsAndDoesNotReadFillsNoMemory) {
  const auto ends = Pair::descriptors();
  auto channel = std::make_unique<LineChannel>(Descriptor(ends[0]), Descriptor(), 1'000);
  Flood flood(ends[1], std::string(1'000'000, 'x'));
  EXPECT_EQ(channel->write(std::string(10'000'000, 'y'), in(std::chrono::seconds(1))), Status::Timeout);
  channel.reset();
  EXPECT_LT(flood.end(), 70'000'000U);
}

TEST(LineChannel, AddressesAreHostAndPort) {
  std::string host;
  std::uint16_t port = 0;
  EXPECT_TRUE(splitAddress("127.0.0.1:80", host, port));
  EXPECT_EQ(host + "|" + std::to_string(port), "127.0.0.1|80");
  EXPECT_TRUE(splitAddress("[::1]:0", host, port));
  EXPECT_EQ(host, "::1");
  for (const char* bad : {"", ":80", "host", "host:", "host:x", "host:65536", "::1:80", "host:-1"}) {
    EXPECT_FALSE(splitAddress(bad, host, port)) << bad;
  }
}

TEST(ChildProcess, AStartedCommandTalksAndIsReapedWithItsFate) {
  auto started = ChildProcess::start("read line; echo \"got $line\"; exit 7");
  auto& child = *started.value();
  LineChannel channel(std::move(child.input), std::move(child.output), 1'000);
  EXPECT_EQ(channel.write("hello\n", in(std::chrono::seconds(5))), Status::Done);
  std::string line;
  EXPECT_EQ(channel.readLine(line, in(std::chrono::seconds(5))), Status::Done);
  EXPECT_EQ(line, "got hello");
  EXPECT_EQ(channel.readLine(line, in(std::chrono::seconds(5))), Status::Closed);
  EXPECT_EQ(child.process.fate(), "ended with status 7");
  // writing to the ended child neither kills us nor hangs
  EXPECT_EQ(channel.write("more\n", in(std::chrono::seconds(5))), Status::Closed);
}

}  // namespace
}  // namespace espalier::server::line_channel_test

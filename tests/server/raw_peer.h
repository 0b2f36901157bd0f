#pragma once

#include <gtest/gtest.h>

#include <sys/socket.h>

#include <string>
#include <utility>

#include "server/remote/processes/line_channel.h"
#include "tests/server/server_fixture.h"

namespace espalier::server {

inline constexpr std::string_view kHello =
    R"({"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1],"roles":["controller"],"name":"probe","version":"1"}})";

/// A peer that sends exactly the bytes it is told to.
class RawPeer {
 public:
  explicit RawPeer(const RunningServer& server) : RawPeer(server.address()) {}
  explicit RawPeer(const std::string& address) : RawPeer(dial(address)) {}

  void send(std::string_view bytes) { (void)channel_.write(bytes, soon()); }
  /// The next line; "(closed)" or "(timeout)" when there is none.
  std::string line() {
    std::string text;
    switch (channel_.readLine(text, soon())) {
      case LineChannel::Status::Done:
        return text;
      case LineChannel::Status::Timeout:
        return "(timeout)";
      default:
        return "(closed)";
    }
  }
  /// The other side has closed the connection, or does soon; lines are skipped.
  [[nodiscard]] bool isClosed() {
    std::string text = line();
    while (text != "(closed)" && text != "(timeout)") {
      text = line();
    }
    return text == "(closed)";
  }
  /// Nothing more is sent; it can still read.
  void endSending() const { (void)::shutdown(socket_, SHUT_WR); }
  std::string ask(std::string_view text) {
    send(std::string(text) + "\n");
    return line();
  }

 private:
  explicit RawPeer(Descriptor socket)
      : socket_(socket.number()), channel_(std::move(socket), Descriptor(), 100'000'000) {}
  static Deadline soon() { return std::chrono::steady_clock::now() + std::chrono::seconds(30); }
  static Descriptor dial(const std::string& address) {
    auto dialled = dialTcp(address, soon());
    EXPECT_TRUE(dialled.has_value());
    return std::move(dialled.value());
  }
  int socket_;
  LineChannel channel_;
};

}  // namespace espalier::server

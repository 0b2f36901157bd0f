#include "server/remote/hosting/dial_bridge.h"

#include "tests/server/server_fixture.h"

namespace espalier::server::dial_bridge_test {
namespace {

TEST(DialBridge, IsForWhatIsNotPlainTcp) {
  for (const char* address : {"tls://a:1", "ws://a:1", "wss://a:1", "unix:/x"}) {
    EXPECT_TRUE(DialBridge::isFor(address)) << address;
  }
  for (const char* address : {"a:1", "127.0.0.1:4321", "tcp://a:1", "[::1]:1", ""}) {
    EXPECT_FALSE(DialBridge::isFor(address)) << address;
  }
}

TEST(DialBridge, AClientSpeaksThroughASocketOfTheFileSystem) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.host = "unix:" + folder.path() + "/socket";
  const RunningServer server(options);
  auto opened = DialBridge::open(options.host, {});
  ASSERT_TRUE(opened.has_value()) << opened.error();
  const auto& bridge = *opened.value();
  auto connected = client::Client::connect(bridge.address(), {});
  ASSERT_TRUE(connected.has_value()) << connected.error().message;
  auto& client = *connected.value();
  const std::string simulation = create(client, kGrowth, R"([{"type":"height"}])");
  EXPECT_EQ(member(resultOf(client.request("simulation.run", named(simulation))), "step"), "6");
  // it takes one connection
  client::ClientOptions impatient;
  impatient.connectTimeout = std::chrono::milliseconds(200);
  EXPECT_FALSE(client::Client::connect(bridge.address(), impatient).has_value());
}

TEST(DialBridge, SaysWhyItCannot) {
  const auto problem = [](const std::string& address) {
    auto opened = DialBridge::open(address, {.trustedFile = {}, .connectTimeout = std::chrono::milliseconds(2'000)});
    return opened ? "(connected)" : opened.error();
  };
  EXPECT_EQ(
      problem("unix:/nonexistent/socket"),
      "Cannot connect to unix:/nonexistent/socket: No such file or directory. Start the server (espalier serve) or "
      "correct the address.");
  EXPECT_EQ(problem("ws://127.0.0.1:1"),
            "Cannot connect to ws://127.0.0.1:1: Connection refused. Start the server (espalier serve) or correct the "
            "address.");
  EXPECT_EQ(
      problem("wss://nowhere"),
      "Cannot connect to wss://nowhere: it is not of the form wss://HOST:PORT. Start the server (espalier serve) or "
      "correct the address.");
}

}  // namespace
}  // namespace espalier::server::dial_bridge_test

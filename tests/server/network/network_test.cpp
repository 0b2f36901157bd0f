#include "server/network/network.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/server/server_fixture.h"

namespace espalier::server::network_test {
namespace {

TEST(Network, AnEndlessStepAfterShortOnesKeepsNoOtherPeerWaiting) {
  // 40 steps of a microsecond each, then one of hundreds of seconds
  std::string model = "Lsystem: 1\nderivation length: 99\nAxiom: A(0)\nA(n) : n < 40 --> A(n+1)\nA(n) --> ";
  model.append(2000, 'B').append("\nB : {i = 0; while (i < 50000000) {i = i + 1;}} * --> B\nendlsystem\n");
  ServerOptions options;
  options.workers = 1;
  const RunningServer server(options);
  const auto other = connectTo(server);
  const std::string mine = create(*other, "Lsystem: 1\nderivation length: 99\nAxiom: A\nA --> AB\nendlsystem\n");
  std::vector<std::pair<std::unique_ptr<client::Client>, std::int64_t>> endless;
  for (int i = 1; i <= 3; ++i) {
    auto hog = connectTo(server);
    const std::string simulation = create(*hog, model);
    for (int step = 1; step <= 41; ++step) {
      ASSERT_EQ(member(resultOf(hog->request("simulation.step", named(simulation))), "step"), std::to_string(step));
    }
    const auto id = hog->send("simulation.step", named(simulation)).value();
    endless.emplace_back(std::move(hog), id);
    for (int step = 1; step <= 5; ++step) {
      ASSERT_EQ(member(resultOf(other->request("simulation.step", named(mine))), "step"),
                std::to_string(5 * (i - 1) + step));
      ASSERT_EQ(resultOf(other->request("ping", "{}")), "{}");
    }
  }
  for (const auto& [hog, step] : endless) {
    EXPECT_FALSE(hog->notify("$/cancel", "{\"id\":" + std::to_string(step) + "}").has_value());
    EXPECT_EQ(static_cast<int>(errorOf(hog->waitFor(step, std::chrono::seconds(30))).code), 1010);
  }
}

}  // namespace
}  // namespace espalier::server::network_test

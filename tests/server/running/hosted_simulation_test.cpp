#include "server/running/hosted_simulation.h"

#include <gtest/gtest.h>

#include "tests/server/server_fixture.h"

namespace espalier::server::hosted_simulation_test {
namespace {

TEST(HostedSimulation, ThePlantIsTheSameOnAnyNumberOfThreadsAndFromItsCheckpoint) {
  std::string expected;
  for (const unsigned threads : {1U, 2U, 4U}) {
    const TemporaryFolder folder;
    ServerOptions options;
    options.dataFolder = folder.path();
    options.threads = threads;
    const RunningServer server(options);
    const auto client = connectTo(server);
    const std::string simulation = create(*client,
                                          "Lsystem: 1\nderivation length: 17\nAxiom: A(1)?E(0.5)\nA(x) --> "
                                          "A(ran(1))[+(90*x)F(x)?E(x)]A(ran(1))\nendlsystem\n",
                                          R"([{"type":"honda","radius":0.01}])", R"("seed":7)");
    resultOf(client->request("simulation.step", named(simulation, R"("steps":7)")));
    resultOf(client->request("simulation.save", named(simulation, R"("checkpoint":"seven")")));
    resultOf(client->request("simulation.step", named(simulation, R"("steps":4)")));
    const std::string hash =
        member(resultOf(client->request("simulation.get", named(simulation, R"("what":"state-hash")"))), "stateHash");
    expected = expected.empty() ? hash : expected;
    EXPECT_EQ(hash, expected) << threads;
    resultOf(client->request("simulation.restore", named(simulation, R"("checkpoint":"seven")")));
    resultOf(client->request("simulation.step", named(simulation, R"("steps":4)")));
    EXPECT_EQ(
        member(resultOf(client->request("simulation.get", named(simulation, R"("what":"state-hash")"))), "stateHash"),
        expected)
        << threads;
  }
}

TEST(HostedSimulation, LoadsWhileTheEnvironmentThatDescribedItselfIsAway) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  const auto answer = [](client::Client& self, const client::IncomingRequest& request) {
    if (request.method == "environment.describe") {
      (void)self.respond(request.id, {R"({"name":"a name of its own","needs":["position"]})"});
    } else if (request.method == "environment.step") {
      (void)self.respond(request.id, {R"({"replies":[]})"});
    } else {
      (void)self.respond(request.id, {"{}"});
    }
  };
  std::string simulation;
  {
    const RunningServer server(options);
    const auto client = connectTo(server);
    const OfferingEnvironment environment(server, "away", answer);
    simulation = create(*client, kGrowth, R"([{"type":"offered","name":"away"}])");
    resultOf(client->request("simulation.step", named(simulation)));
  }
  const RunningServer server(options);
  const auto client = connectTo(server);
  EXPECT_EQ(stringOf(*client, simulation), "F(1)F(1)A?E(0)");
  const auto error = errorOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(static_cast<int>(error.code), 1006);
  EXPECT_EQ(member(error.data, "retryable"), "true");
  // what is saved meanwhile may be of any environment
  resultOf(client->request("simulation.save", named(simulation)));
  const OfferingEnvironment environment(server, "away", answer);
  EXPECT_EQ(member(resultOf(client->request("simulation.step", named(simulation))), "step"), "2");
}

}  // namespace
}  // namespace espalier::server::hosted_simulation_test

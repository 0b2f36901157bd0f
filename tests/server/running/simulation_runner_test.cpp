#include "server/running/simulation_runner.h"

#include "tests/server/server_fixture.h"

namespace espalier::server {
namespace {

TEST(SimulationRunner, WhatIsAnsweredDoesNotRunAnyMore) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, "Lsystem: 1\nderivation length: 3\nAxiom: A\nA --> A\nendlsystem\n");
  resultOf(client->request("stream.open", named(simulation, R"("what":"string")")));
  for (int i = 0; i < 300; ++i) {
    resultOf(client->request(i % 2 == 0 ? "simulation.run" : "simulation.reset", named(simulation)));
    const std::string listed = resultOf(client->request("simulation.list", "{}"));
    ASSERT_NE(listed.find(R"("running":false)"), std::string::npos) << i << listed;
    ASSERT_EQ(member(resultOf(client->request("server.status", "{}")), "running"), "0") << i;
  }
}

}  // namespace
}  // namespace espalier::server

// Models and configurations that could end the server, or compute without end in an environment.
#include "tests/server/server_fixture.h"

namespace espalier::server::runaway_environments_test {
namespace {

TEST(RunawayEnvironments, LightAmongPlacesFarAwayIsAnError) {
  const RunningServer server;
  const auto client = connectTo(server);
  for (const std::string power : {"18", "19", "39", "300"}) {
    const std::string simulation = create(*client,
                                          "Lsystem: 1\nderivation length: 1\nAxiom: LF(10^" + power +
                                              ")?E(1)L\nhomomorphism\nL --> {.f(1)-(90).f(1).}\nendlsystem\n",
                                          R"([{"type":"light"}])");
    const auto error = errorOf(client->request("simulation.step", named(simulation)));
    EXPECT_EQ(error.code, protocol::ErrorCode::EnvironmentFailed) << power;
    EXPECT_NE(error.message.find("places up to 1e17"), std::string::npos) << power << error.message;
  }
}

TEST(RunawayEnvironments, AnInternalStepLongerThanTheStepIsTheStep) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation =
      create(*client, "Lsystem: 1\nderivation length: 9\nAxiom: F(1)?E(1,1,0,0,0,0,0)\nendlsystem\n",
             R"([{"type":"xylem","radius":0.1,"longestStep":1e9,"transpiration":[[0,1],[0.5,0]]}])");
  resultOf(client->request("simulation.step", named(simulation)));
}

TEST(RunawayEnvironments, SolutesThatSpreadTooFastEndWithASentenceOrWithCallSeconds) {
  ServerOptions options;
  options.limits.callSeconds = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const auto errorOfDiffusivity = [&](const std::string& diffusivity) {
    const std::string simulation =
        create(*client, "Lsystem: 1\nderivation length: 9\nAxiom: F(1)?E(1)\nF(x) --> F(x)\nendlsystem\n",
               R"([{"type":"soil-water","solutes":[[0,0,)" + diffusivity + ",0,0,0]]}]");
    return errorOf(client->request("simulation.step", named(simulation)));
  };
  const auto tooFast = errorOfDiffusivity("1e12");
  EXPECT_EQ(tooFast.code, protocol::ErrorCode::EnvironmentFailed);
  EXPECT_NE(tooFast.message.find("they spread too fast for its cells"), std::string::npos) << tooFast.message;
  const auto tooLong = errorOfDiffusivity("1e5");
  EXPECT_NE(tooLong.message.find("callSeconds"), std::string::npos) << tooLong.message;
}

TEST(RunawayEnvironments, AnEnvironmentThatOpensForLongEndsWithCallSeconds) {
  ServerOptions options;
  options.limits.callSeconds = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  // hardly any of ten million markers finds a place in the envelope
  const auto error = errorOf(client->request(
      "simulation.create",
      R"({"model":{"source":"Lsystem: 1\nderivation length: 9\nAxiom: F(1)?E(1)\nF(x) --> F(x)\nendlsystem\n"},"seed":1,)"
      R"("environment":[{"type":"colonization","markerCount":10000000,"spheres":[[0,0,0,0.01]],"markerBox":[-9,-9,-9,9,9,9]}]})"));
  EXPECT_NE(error.message.find("callSeconds"), std::string::npos) << error.message;
}

TEST(RunawayEnvironments, ANarrowPlotEndsWithCallSeconds) {
  ServerOptions options;
  options.limits.callSeconds = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  protocol::JsonWriter params;
  params.beginObject().key("model").beginObject().key("main").text("m.l").key("files").beginObject();
  params.key("m.l").text(
      "Lsystem: 1\nderivation length: 9\nAxiom: A\n"
      "A --> F(0)[+(30)LF(1)?E(3,2,1,1,1)]/(137)F(1)?E(1,1,3,1,1)A\nL --> L\n"
      "homomorphism\nL --> {.f(1)-(90).f(1).}\nendlsystem\n");
  params.key("m.v").text("line style: cylinder\ninitial line width: 0.1\n").endObject().endObject();
  params.key("seed").integer(std::uint64_t{1});
  params.key("environment").raw(R"([{"type":"light","plot":[1,1e15,0,7]}])").endObject();
  const std::string simulation = member(resultOf(client->request("simulation.create", params.take())), "simulation");
  const auto error = errorOf(client->request("simulation.step", named(simulation, R"("steps":3)")));
  EXPECT_NE(error.message.find("callSeconds"), std::string::npos) << error.message;
}

// amounts that plants have taken from a field or given to it come back when the step is given up
TEST(RunawayEnvironments, AFieldThatSpreadsForLongEndsWithCallSecondsAndStaysAsItWas) {
  ServerOptions options;
  options.limits.callSeconds = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  for (
      const std::string configuration :
      {R"({"type":"soil","concentrationRange":[0,9],"gridSize":[64,64,64],"domainSize":[8,8,8],"depletion":true,"sourceMap":[],)"
       R"("diffusionSteps":1000000,"relaxationFactor":0.5})",
       R"({"type":"soil","concentrationRange":[0,9],"gridSize":[64,64,64],"domainSize":[8,8,8],"depletion":true,"sourceMap":[],)"
       R"("compatible":true,"diffusionSteps":1000000,"relaxationFactor":0.5})",
       R"({"type":"emission","gridSize":[64,64,64],"cellSize":0.1,"diffusivity":80})"}) {
    const std::string simulation =
        create(*client, "Lsystem: 1\nderivation length: 9\nAxiom: F(1)?E(1)\nF(x) --> F(x)\nendlsystem\n",
               "[" + configuration + "]");
    const auto hash = [&] {
      return member(resultOf(client->request("simulation.get", named(simulation, R"("what":"state-hash")"))),
                    "stateHash");
    };
    const std::string before = hash();
    const auto error = errorOf(client->request("simulation.step", named(simulation)));
    EXPECT_NE(error.message.find("callSeconds"), std::string::npos) << configuration << error.message;
    EXPECT_EQ(hash(), before) << configuration;
  }
}

}  // namespace
}  // namespace espalier::server::runaway_environments_test

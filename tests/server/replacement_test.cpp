// Simulations that take the place of others, and what a simulation tells so that another can be made like it.
#include "protocol/json_writer.h"
#include "tests/server/raw_peer.h"

namespace espalier::server::replacement_test {
namespace {

constexpr std::string_view kShortChain = "Lsystem: 1\nderivation length: 3\nAxiom: FA\nA --> FA\nendlsystem\n";
constexpr std::string_view kOtherModel =
    "Lsystem: 1\nderivation length: 5\nAxiom: B(2)\nB(x) --> B(x)G(x)\nendlsystem\n";

std::string frameFor(client::Client& client) {
  while (const auto notification = client.nextNotification(std::chrono::seconds(30))) {
    if (notification->method == "stream.data") {
      return notification->paramsJson;
    }
  }
  ADD_FAILURE() << "no frame came";
  return "{}";
}

std::string inPlaceOf(const std::string& simulation) {
  return "\"simulation\":\"" + simulation + "\"";
}

TEST(Replacement, StreamsGoOnWithTheNewModel) {
  const RunningServer server;
  const auto client = connectTo(server);
  const auto viewer = connectTo(server);
  const std::string simulation = create(*client, kShortChain);
  for (const std::string what : {"string", "statistics", "geometry\",\"format\":\"columns"}) {
    resultOf(viewer->request("stream.open", named(simulation, R"("what":")" + what + "\"")));
    frameFor(*viewer);
  }
  resultOf(client->request("simulation.step", named(simulation, R"("steps":3)")));
  for (int i = 0; i < 9; ++i) {
    frameFor(*viewer);
  }
  EXPECT_EQ(create(*client, kOtherModel, "[]", inPlaceOf(simulation) + R"(,"name":"other")"), simulation);
  int strings = 0;
  for (int i = 0; i < 3; ++i) {
    const std::string frame = frameFor(*viewer);
    EXPECT_EQ(member(frame, "step"), "0");
    strings += member(frame, "string") == "B(2)" ? 1 : 0;
  }
  EXPECT_EQ(strings, 1);
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(stringOf(*client, simulation), "B(2)G(2)");
  const std::string list = resultOf(client->request("simulation.list", "{}"));
  EXPECT_NE(list.find(R"("derivationLength":5)"), std::string::npos) << list;
  EXPECT_NE(list.find(R"("name":"other")"), std::string::npos) << list;
}

TEST(Replacement, AModelWithErrorsLeavesTheSimulationAsItIs) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kShortChain);
  resultOf(client->request("simulation.step", named(simulation)));
  protocol::JsonWriter model;
  model.beginObject().key("source").text("Lsystem: 1\nAxiom: A(\nendlsystem\n").endObject();
  const auto refused =
      client->request("simulation.create", "{" + inPlaceOf(simulation) + ",\"model\":" + model.take() + "}");
  EXPECT_EQ(errorOf(refused).code, protocol::ErrorCode::Model);
  EXPECT_EQ(stringOf(*client, simulation), "FFA");
}

TEST(Replacement, AFullServerHasRoomForIt) {
  ServerOptions options;
  options.limits.simulations = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kShortChain);
  EXPECT_EQ(create(*client, kOtherModel, "[]", inPlaceOf(simulation)), simulation);
  EXPECT_EQ(stringOf(*client, simulation), "B(2)");
}

TEST(Replacement, IsThereAfterARestartAndAnIdentifierThatIsFreeIsGiven) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  std::string simulation;
  {
    const RunningServer server(options);
    const auto client = connectTo(server);
    simulation = create(*client, kShortChain);
    create(*client, kOtherModel, "[]", inPlaceOf(simulation));
    resultOf(client->request("simulation.step", named(simulation)));
  }
  {
    const RunningServer server(options);
    EXPECT_EQ(stringOf(*connectTo(server), simulation), "B(2)G(2)");
  }
  const RunningServer server;
  const auto client = connectTo(server);
  EXPECT_EQ(create(*client, kShortChain, "[]", inPlaceOf(simulation)), simulation);
  EXPECT_EQ(stringOf(*client, simulation), "FA");
  const auto refused = client->request("simulation.create", R"({"simulation":"tree","model":{"source":"Axiom: A"}})");
  EXPECT_EQ(errorOf(refused).message,
            "params.simulation: expected an identifier that a server gave, as sim-5d03a1c7e2b4, found \"tree\"");
}

TEST(Replacement, WhatASimulationSaysOfItsModelMakesItAgain) {
  const RunningServer server;
  const auto client = connectTo(server);
  // two models whose files have the same name
  const std::string first =
      R"({"name":"oak","source":"Lsystem: 1\nModule: ?Seed(asks)\nAxiom: FA\nA --> F[+f(2)?Seed(1)]A\nendlsystem\n"})";
  const std::string second =
      R"({"name":"grass","colour":3,"source":"Lsystem: 1\n#define L 2\nAxiom: G\nG --> GG(L)\nendlsystem\n"})";
  const std::string forest = resultOf(client->request(
      "simulation.create", R"({"models":[)" + first + "," + second +
                               R"(],"plants":[{"position":[0,0,0]},{"model":"grass","position":[3,0,0],"turn":90}],)"
                               R"("seeds":{"spacing":0.5},"seed":7,"derivationLength":4})"));
  const std::string simulation = member(forest, "simulation");
  resultOf(client->request("simulation.set", named(simulation, R"("parameters":{"L":5})")));
  resultOf(client->request("simulation.run", named(simulation)));
  const std::string model =
      member(resultOf(client->request("simulation.get", named(simulation, R"("what":"model")"))), "model");
  EXPECT_EQ(member(model, "main"), "model.l");
  EXPECT_EQ(member(model, "parameters"), R"({"L":"5"})");
  EXPECT_EQ(member(model, "derivationLength"), "4");
  const std::string described = member(model, "forest");
  EXPECT_EQ(member(described, "models"),
            R"([{"colour":0,"file":"model.l","name":"oak"},{"colour":3,"file":"grass-model.l","name":"grass"}])");
  // the same again, from a folder with this forest.json
  protocol::JsonWriter text;
  text.text(described);
  std::string files = member(model, "files");
  files.back() = ',';
  files += "\"forest.json\":" + text.take() + "}";
  const std::string again =
      member(resultOf(client->request("simulation.create",
                                      R"({"model":{"files":)" + files + R"(,"main":"model.l"},"seed":7})")),
             "simulation");
  resultOf(client->request("simulation.set", named(again, "\"parameters\":" + member(model, "parameters"))));
  resultOf(client->request("simulation.run", named(again)));
  for (const std::string plant : {"0", "1", "2"}) {
    const auto grown = [&](const std::string& name) {
      return member(resultOf(client->request("simulation.get", named(name, R"("what":"string","plant":)" + plant))),
                    "string");
    };
    EXPECT_EQ(grown(again), grown(simulation));
  }
  const auto missing = client->request(
      "simulation.create",
      R"({"model":{"files":{"a.l":"Axiom: A","forest.json":"{\"models\":[{\"name\":\"a\",\"file\":\"b.l\"}],\"plants\":[{\"position\":[0,0,0]}]}"},"main":"a.l"}})");
  EXPECT_EQ(errorOf(missing).message, "The model's 'forest.json': the model file 'b.l' did not come with the request");
}

}  // namespace
}  // namespace espalier::server::replacement_test

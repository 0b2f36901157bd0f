#include "server/server.h"

#include <sys/types.h>
#include <sys/wait.h>

#include <filesystem>

#include "server/store/store.h"
#include "tests/server/raw_peer.h"

namespace espalier::server::server_test {
namespace {

TEST(Server, GrowsAPlantThroughTheWholeDialogue) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string created =
      resultOf(client->request("simulation.create", createParams(kGrowth, R"([{"type":"height"}])", R"("seed":7)")));
  EXPECT_EQ(member(created, "step"), "0");
  EXPECT_EQ(member(created, "seed"), "7");
  EXPECT_EQ(member(created, "derivationLength"), "6");
  const std::string simulation = member(created, "simulation");
  const std::string stepped = resultOf(client->request("simulation.step", named(simulation, R"("steps":3)")));
  EXPECT_EQ(member(stepped, "step"), "3");
  EXPECT_EQ(member(stepped, "finished"), "false");
  EXPECT_EQ(member(stepped, "truncated"), "false");
  EXPECT_EQ(member(member(stepped, "statistics"), "queries"), "3");
  EXPECT_EQ(member(member(stepped, "statistics"), "modules"), "5");
  // the apex asks at heights 1, 2, 3 and stops at 3
  EXPECT_EQ(stringOf(*client, simulation), "F(1)F(1)F(1)?E(3)");
  const std::string run = resultOf(client->request("simulation.run", named(simulation)));
  EXPECT_EQ(member(run, "step"), "6");
  EXPECT_EQ(member(run, "finished"), "true");
}

TEST(Server, DrawsASeedOnceAndSaysWhich) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string a = resultOf(client->request("simulation.create", createParams(kGrowth)));
  const std::string b = resultOf(client->request("simulation.create", createParams(kGrowth)));
  EXPECT_NE(member(a, "seed"), member(b, "seed"));
  EXPECT_EQ(
      member(
          member(resultOf(client->request("simulation.get", named(member(a, "simulation"), R"("what":"information")"))),
                 "information"),
          "seed"),
      member(a, "seed"));
}

TEST(Server, AModelWithErrorsCreatesNothingAndSaysWhere) {
  const RunningServer server;
  const auto client = connectTo(server);
  const auto error = errorOf(client->request("simulation.create", createParams("Lsystem: 1\nAxiom: A(\nendlsystem\n")));
  EXPECT_EQ(static_cast<int>(error.code), 1009);
  EXPECT_NE(error.data.find("\"line\":2"), std::string::npos) << error.data;
  EXPECT_EQ(member(resultOf(client->request("simulation.list", "{}")), "simulations"), "[]");
  const std::string checked =
      resultOf(client->request("model.check", R"({"source":"Lsystem: 1\nAxiom: A\nA --> AA\nendlsystem\n"})"));
  EXPECT_EQ(member(checked, "valid"), "true");
}

TEST(Server, CreatingWarnsAboutQueriesThatNobodyAnswersAndFilesThatAreNotWritten) {
  RunningServer server;
  const auto client = connectTo(server);
  const std::string text = "Lsystem: 1\nStart: {f = fopen(\"out\", \"w\");}\nAxiom: A?E(0)\nA --> A\nendlsystem\n";
  const std::string alone = resultOf(client->request("simulation.create", createParams(text)));
  EXPECT_NE(alone.find("models cannot write files here"), std::string::npos) << alone;
  EXPECT_NE(alone.find("?E gets no answer: no environment is given"), std::string::npos) << alone;
  const std::string answered =
      resultOf(client->request("simulation.create", createParams(text, R"([{"type":"height"}])")));
  EXPECT_EQ(answered.find("gets no answer"), std::string::npos) << answered;
}

TEST(Server, AnUnknownEnvironmentIsAnErrorWithItsPathAndTheNearestName) {
  const RunningServer server;
  const auto client = connectTo(server);
  const auto error = errorOf(client->request("simulation.create", createParams(kGrowth, R"([{"type":"hight"}])")));
  EXPECT_EQ(static_cast<int>(error.code), -32602);
  EXPECT_NE(error.message.find("params.environment[0]"), std::string::npos) << error.message;
  EXPECT_NE(error.message.find("'height'"), std::string::npos) << error.message;
}

TEST(Server, AFieldFileFromTheWireReadsTheFilesThatCameWithIt) {
  const RunningServer server;
  const auto client = connectTo(server);
  // two discs of one vigor, nearer than the radius of the specification file: both are refused
  const std::string model = "Lsystem: 1\nderivation length: 1\nAxiom: ?E(1)[+F?E(1)]\nA --> A\nendlsystem\n";
  const std::string environment =
      R"([{"type":"field","main":"d.e","files":{"d.e":"executable: honda81 d.spec\nturtle position: %f %f %f\n","d.spec":"radius: 5\n3D case: on\n"}}])";
  const std::string created = resultOf(client->request("simulation.create", createParams(model, environment)));
  resultOf(client->request("simulation.step", named(member(created, "simulation"))));
  EXPECT_EQ(stringOf(*client, member(created, "simulation")), "?E(0)[+F?E(0)]");

  auto error = errorOf(client->request("simulation.create",
                                       createParams(model, R"([{"type":"field","main":"x.e","files":{"d.e":""}}])")));
  EXPECT_NE(error.message.find(
                "params.environment[0].main: expected the name of the environment specification (.e) among \"files\""),
            std::string::npos)
      << error.message;
  error = errorOf(client->request("simulation.create", createParams(model, R"([{"type":"field","main":"x.e"}])")));
  EXPECT_NE(error.message.find("params.environment[0].files"), std::string::npos) << error.message;
}

TEST(Server, ALoadedModelServesSeveralSimulations) {
  const RunningServer server;
  const auto client = connectTo(server);
  protocol::JsonWriter params;
  params.beginObject().key("source").text(kGrowth).endObject();
  const std::string model = member(resultOf(client->request("model.load", params.view())), "model");
  for (int i = 0; i < 2; ++i) {
    const std::string created = resultOf(client->request(
        "simulation.create", R"({"model":{"loaded":")" + model + R"("},"environment":[{"type":"height"}]})"));
    const std::string simulation = member(created, "simulation");
    resultOf(client->request("simulation.step", named(simulation, R"("until":2)")));
    EXPECT_EQ(stringOf(*client, simulation), "F(1)F(1)F(1)A?E(2)");
  }
}

TEST(Server, SimulationsBelongToTheServerAndOutliveTheirSession) {
  const RunningServer server;
  std::string simulation;
  {
    const auto client = connectTo(server);
    simulation = create(*client, kGrowth, R"([{"type":"height"}])");
  }
  const auto other = connectTo(server);
  resultOf(other->request("simulation.step", named(simulation)));
  EXPECT_EQ(stringOf(*other, simulation), "F(1)F(1)A?E(1)");
  resultOf(other->request("simulation.delete", named(simulation)));
  EXPECT_EQ(static_cast<int>(errorOf(other->request("simulation.step", named(simulation))).code), 1011);
}

TEST(Server, SaveAndRestoreGoBackToTheSameState) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kGrowth, R"([{"type":"height"}])", R"("seed":3)");
  resultOf(client->request("simulation.step", named(simulation)));
  const std::string hash =
      member(resultOf(client->request("simulation.get", named(simulation, R"("what":"state-hash")"))), "stateHash");
  const std::string snapshot = member(resultOf(client->request("simulation.save", named(simulation))), "snapshot");
  resultOf(client->request("simulation.step", named(simulation, R"("steps":2)")));
  const std::string grown = stringOf(*client, simulation);
  resultOf(client->request("simulation.restore", named(simulation, "\"snapshot\":\"" + snapshot + "\"")));
  EXPECT_EQ(
      member(resultOf(client->request("simulation.get", named(simulation, R"("what":"state-hash")"))), "stateHash"),
      hash);
  resultOf(client->request("simulation.step", named(simulation, R"("steps":2)")));
  EXPECT_EQ(stringOf(*client, simulation), grown);
  EXPECT_EQ(
      static_cast<int>(errorOf(client->request("simulation.restore", named(simulation, R"("snapshot":"AAAA")"))).code),
      1013);
}

TEST(Server, ResetGoesToStepZeroWithAnotherSeedWhenGiven) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kGrowth, R"([{"type":"height"}])", R"("seed":3)");
  resultOf(client->request("simulation.step", named(simulation)));
  const std::string reset = resultOf(client->request("simulation.reset", named(simulation, R"("seed":9)")));
  EXPECT_EQ(member(reset, "step"), "0");
  EXPECT_EQ(member(reset, "seed"), "9");
  EXPECT_EQ(stringOf(*client, simulation), "F(1)A?E(0)");
}

TEST(Server, KeepsSimulationsInTheDataFolderAcrossRestarts) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  std::string simulation;
  {
    const RunningServer server(options);
    const auto client = connectTo(server);
    simulation = create(*client, kGrowth, R"([{"type":"height"}])", R"("seed":3,"name":"my plant")");
    EXPECT_EQ(member(resultOf(client->request("simulation.step", named(simulation))), "saved"), "true");
  }
  const RunningServer server(options);
  const auto client = connectTo(server);
  EXPECT_EQ(stringOf(*client, simulation), "F(1)F(1)A?E(1)");
  const std::string information =
      member(resultOf(client->request("simulation.get", named(simulation, R"("what":"information")"))), "information");
  EXPECT_EQ(member(information, "name"), "my plant");
  EXPECT_EQ(member(information, "seed"), "3");
  EXPECT_EQ(member(resultOf(client->request("simulation.run", named(simulation))), "step"), "6");
  EXPECT_EQ(stringOf(*client, simulation), "F(1)F(1)F(1)?E(3)");
}

TEST(Server, ADeletedSimulationIsGoneFromTheDataFolder) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  {
    const RunningServer server(options);
    const auto client = connectTo(server);
    resultOf(client->request("simulation.delete", named(create(*client, kGrowth))));
  }
  const RunningServer server(options);
  EXPECT_EQ(member(resultOf(connectTo(server)->request("simulation.list", "{}")), "simulations"), "[]");
}

TEST(Server, ADamagedSimulationIsListedWithItsReasonAndCanBeDeleted) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  std::string simulation;
  {
    const RunningServer server(options);
    simulation = create(*connectTo(server), kGrowth);
  }
  {
    Store store(folder.path());
    ASSERT_EQ(store.open(), std::nullopt);
    ASSERT_EQ(store.save({"sim-broken", "{}", 4}, "no snapshot"), std::nullopt);
    const auto simulations = store.simulations();
    for (Store::Entry entry : simulations.value()) {
      if (entry.id == simulation) {
        entry.id = "sim-cut";
        ASSERT_EQ(store.save(entry, "no snapshot"), std::nullopt);
      }
    }
  }
  {
    const RunningServer server(options);
    const auto client = connectTo(server);
    EXPECT_EQ(stringOf(*client, simulation), "F(1)A?E(0)");
    const std::string list = resultOf(client->request("simulation.list", "{}"));
    EXPECT_NE(list.find("sim-broken"), std::string::npos) << list;
    EXPECT_NE(list.find("\"damaged\":\"This is not a snapshot: it does not begin with"), std::string::npos) << list;
    const auto error = errorOf(client->request("simulation.step", named("sim-cut")));
    EXPECT_EQ(static_cast<int>(error.code), 1014);
    EXPECT_EQ(error.message.substr(0, 66), "Simulation 'sim-cut' could not be loaded: This is not a snapshot: ");
    EXPECT_TRUE(error.message.ends_with(" simulation.delete removes it.")) << error.message;
    resultOf(client->request("simulation.delete", named("sim-broken")));
    EXPECT_EQ(static_cast<int>(errorOf(client->request("simulation.delete", named("sim-broken"))).code), 1011);
  }
  const RunningServer server(options);
  const std::string list = resultOf(connectTo(server)->request("simulation.list", "{}"));
  EXPECT_EQ(list.find("sim-broken"), std::string::npos) << list;
  EXPECT_NE(list.find("sim-cut"), std::string::npos) << list;
}

TEST(Server, SavesAsOftenAsTheSimulationWasToldTo) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  const RunningServer server(options);
  const auto client = connectTo(server);
  const auto isSaved = [&](const std::string& simulation, std::string_view more = {}) {
    return member(resultOf(client->request("simulation.step", named(simulation, more))), "saved");
  };
  const std::string third = create(*client, kGrowth, {}, R"("save":3)");
  EXPECT_EQ(isSaved(third), "false");
  EXPECT_EQ(isSaved(third), "false");
  EXPECT_EQ(isSaved(third), "true");
  EXPECT_EQ(isSaved(third, R"("until":100)"), "true");  // the last step, 6
  const std::string asked = create(*client, kGrowth, {}, R"("save":"request")");
  EXPECT_EQ(isSaved(asked), "false");
  EXPECT_EQ(member(resultOf(client->request("simulation.save", named(asked, R"("snapshot":false)"))), "saved"), "true");
  EXPECT_EQ(member(resultOf(client->request("simulation.get", named(asked, R"("what":"information")"))), "step"), "1");
  const std::string never = create(*client, kGrowth, {}, R"("save":false)");
  EXPECT_EQ(member(resultOf(client->request("simulation.save", named(never, R"("snapshot":false)"))), "saved"),
            "false");
  EXPECT_EQ(errorOf(client->request("simulation.create", createParams(kGrowth, {}, R"("save":"often")"))).message,
            "params.save: expected true, false, a number of steps or \"request\", found \"often\"");
}

TEST(Server, ShutdownSavesWhatIsSavedEverySoOften) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  std::string simulation;
  {
    const RunningServer server(options);
    const auto client = connectTo(server);
    simulation = create(*client, kGrowth, {}, R"("save":100)");
    resultOf(client->request("simulation.step", named(simulation, R"("steps":2)")));
  }
  const RunningServer server(options);
  EXPECT_EQ(stringOf(*connectTo(server), simulation), "F(1)F(1)F(1)A?E(0)");
}

TEST(Server, AStepThatCannotBeSavedIsAnErrorAndTheNextOneWaitsForRoom) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  options.limits.storeBytes = 200'000;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string small = create(*client, kGrowth);
  const std::string large =
      create(*client, "Lsystem: 1\nderivation length: 30\nAxiom: A(1)\nA(x) --> A(ran(1))A(ran(1))\nendlsystem\n", {},
             R"("seed":1)");
  const auto error = errorOf(client->request("simulation.run", named(large)));
  EXPECT_EQ(static_cast<int>(error.code), 1014);
  EXPECT_NE(error.message.find(" is complete, but the data folder '" + folder.path() +
                               "' cannot be written: database or disk is full."),
            std::string::npos)
      << error.message;
  EXPECT_NE(error.message.find("No further step is made before it is saved."), std::string::npos) << error.message;
  const std::string step = member(error.data, "step");
  EXPECT_EQ(member(resultOf(client->request("simulation.get", named(large, R"("what":"statistics")"))), "step"), step);
  // it does not go on, whatever is asked
  EXPECT_EQ(member(errorOf(client->request("simulation.step", named(large))).data, "step"), step);
  // others do
  EXPECT_EQ(member(resultOf(client->request("simulation.step", named(small))), "saved"), "true");
}

TEST(Server, CheckpointsAreKeptByNameAcrossRestarts) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  std::string simulation;
  {
    const RunningServer server(options);
    const auto client = connectTo(server);
    simulation = create(*client, kGrowth);
    resultOf(client->request("simulation.step", named(simulation)));
    EXPECT_EQ(resultOf(client->request("simulation.save", named(simulation, R"("checkpoint":"young")"))),
              R"({"checkpoint":"young","saved":true,"step":1})");
    resultOf(client->request("simulation.run", named(simulation)));
  }
  const RunningServer server(options);
  const auto client = connectTo(server);
  EXPECT_EQ(member(member(resultOf(client->request("simulation.get", named(simulation, R"("what":"checkpoints")"))),
                          "checkpoints"),
                   "0"),
            "(no 0)");
  EXPECT_EQ(
      member(resultOf(client->request("simulation.restore", named(simulation, R"("checkpoint":"young")"))), "step"),
      "1");
  EXPECT_EQ(stringOf(*client, simulation), "F(1)F(1)A?E(0)");
  EXPECT_EQ(errorOf(client->request("simulation.restore", named(simulation, R"("checkpoint":"old")"))).message,
            "The simulation stays as it is: there is no checkpoint 'old'; simulation.get with \"what\":\"checkpoints\" "
            "lists them.");
}

TEST(Server, LoadedModelsAreThereAfterARestart) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  protocol::JsonWriter params;
  params.beginObject().key("source").text(kGrowth).endObject();
  std::string model;
  {
    const RunningServer server(options);
    model = member(resultOf(connectTo(server)->request("model.load", params.view())), "model");
  }
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string created =
      resultOf(client->request("simulation.create", R"({"model":{"loaded":")" + model + R"("}})"));
  EXPECT_EQ(stringOf(*client, member(created, "simulation")), "F(1)A?E(0)");
  EXPECT_NE(member(resultOf(client->request("model.load", params.view())), "model"), model);
}

TEST(Server, LimitsAreNamedInTheErrorsTheyCause) {
  ServerOptions options;
  options.limits.simulations = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  (void)create(*client, kGrowth);
  const auto error = errorOf(client->request("simulation.create", createParams(kGrowth)));
  EXPECT_EQ(static_cast<int>(error.code), 1004);
  EXPECT_EQ(error.message, "the limit 'simulations' is 1, and this is 2. Delete one first.");
}

TEST(Server, AModuleLimitStopsTheStepAndTheSimulationStays) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, "Lsystem: 1\nderivation length: 9\nAxiom: A\nA --> AA\nendlsystem\n",
                                        {}, R"("limits":{"modules":4})");
  const auto error = errorOf(client->request("simulation.step", named(simulation, R"("steps":5)")));
  EXPECT_EQ(static_cast<int>(error.code), 1004);
  // by the name that the option has, at the last completed step
  EXPECT_EQ(error.message.substr(0, 60), "step 3, plant 0: the string has more than 4 modules (limit m");
  EXPECT_NE(error.message.find("(limit modules). The simulation stays at step 2."), std::string::npos) << error.message;
  EXPECT_EQ(member(error.data, "limit"), "modules");
  EXPECT_EQ(member(error.data, "bound"), "4");
  EXPECT_EQ(member(error.data, "step"), "2");
  EXPECT_EQ(stringOf(*client, simulation), "AAAA");
}

TEST(Server, ErrorsNameTheLastCompletedStepWhateverFailed) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kGrowth, R"([{"type":"height"}])");
  resultOf(client->request("simulation.step", named(simulation, R"("steps":2)")));
  const auto restore = errorOf(client->request("simulation.restore", named(simulation, R"("snapshot":"AAAA")")));
  EXPECT_EQ(member(restore.data, "step"), "2") << restore.message;
  const std::string growing =
      create(*client, "Lsystem: 1\nderivation length: 9\nAxiom: A(1)\nA(x) --> A(x*1.0e200)\nendlsystem\n");
  const auto model = errorOf(client->request("simulation.run", named(growing)));
  EXPECT_EQ(static_cast<int>(model.code), 1008);
  EXPECT_EQ(member(model.data, "step"), "1") << model.message;
}

TEST(Server, AGalleryFolderThatIsNotThereIsRefused) {
  ServerOptions options;
  options.logLevel = "off";
  options.galleryFolder = "no-such-folder";
  EXPECT_EQ(Server(options).listen().value_or(""),
            "there is no gallery folder 'no-such-folder': give --gallery a folder of model folders, or leave it out.");
}

TEST(Server, RefusesAnAddressBeyondLoopbackWithoutTokenAndWithoutInsecure) {
  ServerOptions options;
  options.host = "0.0.0.0";
  options.logLevel = "off";
  EXPECT_EQ(Server(options).listen().value_or("").substr(0, 70),
            "'0.0.0.0' can be reached from other machines: give a token that client");
  options.tokens = {tokenOf("alice", "secret", {protocol::Role::Viewer})};
  EXPECT_NE(Server(options).listen().value_or("").find("--insecure"), std::string::npos);
}

TEST(Server, APortInUseIsOneLineThatSaysWhatToDo) {
  const RunningServer server;
  ServerOptions options;
  options.logLevel = "off";
  const std::string address = server.address();
  options.port = static_cast<std::uint16_t>(std::stoi(address.substr(address.find(':') + 1)));
  const std::string problem = Server(options).listen().value_or("");
  EXPECT_NE(problem.find("the port is in use. Choose another with --listen, or port 0"), std::string::npos) << problem;
  EXPECT_EQ(problem.find('\n'), std::string::npos);
}

TEST(Server, ShutdownTellsSessionsAndFinishesTheRunningStep) {
  RunningServer server;
  const auto controller = connectTo(server);
  std::atomic<bool> isAsked{false};
  std::atomic<bool> isReleased{false};
  auto environment = std::make_unique<OfferingEnvironment>(
      server, "slow", [&](client::Client& self, const client::IncomingRequest& request) {
        if (request.method != "environment.step") {
          (void)self.respondError(request.id, {protocol::ErrorCode::UnknownMethod, "no", {}});
          return;
        }
        isAsked = true;
        isAsked.notify_all();
        isReleased.wait(false);
        (void)self.respond(request.id, R"({"replies":[{"id":0,"parameters":[1]}]})");
      });
  const std::string simulation = create(*controller, kGrowth, R"([{"type":"offered","name":"slow"}])");
  const auto id = controller->send("simulation.step", named(simulation)).value();
  isAsked.wait(false);
  std::thread stopping([&] { server.stop(); });
  const auto told = controller->nextNotification(std::chrono::seconds(30));
  ASSERT_TRUE(told.has_value());
  EXPECT_EQ(told->method, "server.shutdown");
  isReleased = true;
  isReleased.notify_all();
  EXPECT_EQ(member(resultOf(controller->waitFor(id, std::chrono::seconds(30))), "step"), "1");
  stopping.join();
  environment.reset();
}

TEST(Server, CancelGivesUpARunBetweenStepsOrWithinOne) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation =
      create(*client, "Lsystem: 1\nderivation length: 100000000\nAxiom: A\nA --> A\nendlsystem\n");
  const auto id = client->send("simulation.run", named(simulation)).value();
  EXPECT_FALSE(client->notify("$/cancel", "{\"id\":" + std::to_string(id) + "}").has_value());
  const auto error = errorOf(client->waitFor(id, std::chrono::seconds(30)));
  EXPECT_EQ(static_cast<int>(error.code), 1010);
  EXPECT_EQ(member(resultOf(client->request("simulation.step", named(simulation))), "truncated"), "false");
}

/// A model whose every step takes hundreds of seconds: no loop alone exceeds the limit of its iterations.
std::string endlessModel() {
  return "Lsystem: 1\nderivation length: 9\nAxiom: " + std::string(2000, 'A') +
         "\nA : {i = 0; while (i < 50000000) {i = i + 1;}} * --> A\nendlsystem\n";
}

TEST(Server, WhoLeavesWithinAStepKeepsNoWorkerBusy) {
  const RunningServer server;
  auto leaver = connectTo(server);
  const std::string simulation = create(*leaver, endlessModel());
  (void)leaver->send("simulation.step", named(simulation));
  const auto other = connectTo(server);
  std::string running = "0";
  for (int i = 0; i < 1'000'000 && running == "0"; ++i) {
    running = member(resultOf(other->request("server.status", "{}")), "running");
  }
  ASSERT_EQ(running, "1");
  leaver.reset();
  // answered only when the step is given up
  EXPECT_EQ(member(resultOf(other->request("simulation.get", named(simulation, R"("what":"string")"))), "step"), "0");
}

void cancelAndExpectIt(client::Client& client, std::int64_t id) {
  EXPECT_FALSE(client.notify("$/cancel", "{\"id\":" + std::to_string(id) + "}").has_value());
  EXPECT_EQ(static_cast<int>(errorOf(client.waitFor(id, std::chrono::seconds(30))).code), 1010);
}

TEST(Server, EndlessStepsOfOneClientKeepNobodyElseWaiting) {
  ServerOptions options;
  options.workers = 1;
  const RunningServer server(options);
  const auto hog = connectTo(server);
  std::vector<std::int64_t> steps;
  for (int i = 0; i < 3; ++i) {
    steps.push_back(hog->send("simulation.step", named(create(*hog, endlessModel()))).value());
  }
  const auto other = connectTo(server);
  // short requests, then steps of its own; each would wait for hundreds of seconds
  EXPECT_EQ(
      member(resultOf(other->request("model.check", R"({"source":"Lsystem: 1\nAxiom: A\nA --> A\nendlsystem\n"})")),
             "valid"),
      "true");
  const std::string simulation = create(*other, kGrowth, R"([{"type":"height"}])");
  EXPECT_EQ(stringOf(*other, simulation), "F(1)A?E(0)");
  EXPECT_EQ(member(resultOf(other->request("simulation.run", named(simulation))), "step"), "6");
  for (const std::int64_t step : steps) {
    cancelAndExpectIt(*hog, step);
  }
}

TEST(Server, ACallBeyondItsSecondsIsEndedAndTheSimulationStays) {
  ServerOptions options;
  options.limits.callSeconds = 1;
  options.limits.simulation.maximumLoopIterations = UINT64_MAX;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation = create(*client, endlessModel());
  const auto error = errorOf(client->request("simulation.step", named(simulation, R"("steps":5)")));
  EXPECT_EQ(static_cast<int>(error.code), 1004);
  EXPECT_EQ(error.message,
            "the limit 'callSeconds' is 1, and this has computed longer. The simulation stays at step 0. Use a smaller "
            "model, or start the server with a higher --limit callSeconds=N.");
  EXPECT_EQ(error.data, R"({"bound":1,"limit":"callSeconds","step":0,"value":2})");
  EXPECT_EQ(member(resultOf(client->request("simulation.get", named(simulation, R"("what":"statistics")"))), "step"),
            "0");
  // also while it is being created
  const auto unmade = errorOf(client->request(
      "simulation.create",
      createParams(
          "Lsystem: 1\nStart: {i = 0; while (i < 1000000000000) {i = i + 1;}}\nAxiom: A\nA --> A\nendlsystem\n")));
  EXPECT_EQ(
      unmade.message,
      "the limit 'callSeconds' is 1, and this has computed longer. Nothing was created. Use a smaller model, or start "
      "the server with a higher --limit callSeconds=N.");
}

TEST(Server, PauseEndsARunBetweenStepsAndAskingAgainGoesOn) {
  const RunningServer server;
  const auto runner = connectTo(server);
  const std::string simulation =
      create(*runner, "Lsystem: 1\nderivation length: 100000000\nAxiom: A\nA --> A\nendlsystem\n");
  const auto id = runner->send("simulation.run", named(simulation)).value();
  const auto other = connectTo(server);
  std::string paused = "0";
  std::string step;
  for (int i = 0; i < 1'000'000 && paused == "0"; ++i) {
    const std::string result = resultOf(other->request("simulation.pause", named(simulation)));
    paused = member(result, "paused");
    step = member(result, "step");
  }
  const std::string run = resultOf(runner->waitFor(id, std::chrono::seconds(30)));
  EXPECT_EQ(member(run, "truncated"), "true");
  EXPECT_EQ(member(run, "step"), step);
  EXPECT_EQ(member(resultOf(other->request("simulation.step", named(simulation))), "truncated"), "false");
}

TEST(Server, AForkGoesItsOwnWayFromTheSameState) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  const RunningServer server(options);
  const auto client = connectTo(server);
  const auto hash = [&](const std::string& simulation) {
    return member(resultOf(client->request("simulation.get", named(simulation, R"("what":"state-hash")"))),
                  "stateHash");
  };
  const std::string original = create(*client, kGrowth, R"([{"type":"height"}])", R"("seed":3)");
  resultOf(client->request("simulation.step", named(original)));
  const std::string forked = resultOf(client->request("simulation.fork", named(original, R"("name":"other")")));
  const std::string fork = member(forked, "simulation");
  EXPECT_EQ(member(forked, "step"), "1");
  EXPECT_EQ(member(forked, "seed"), "3");
  EXPECT_EQ(hash(fork), hash(original));
  resultOf(client->request("simulation.step", named(fork)));
  EXPECT_NE(hash(fork), hash(original));
  resultOf(client->request("simulation.step", named(original)));
  EXPECT_EQ(hash(fork), hash(original));
  EXPECT_NE(resultOf(client->request("simulation.list", "{}")).find("\"name\":\"other\""), std::string::npos);
}

TEST(Server, StatusTellsWhatIsHeldInMemoryAndOnDisk) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string empty = member(resultOf(client->request("server.status", "{}")), "memory");
  EXPECT_EQ(member(empty, "stringBytes"), "0");
  const std::string simulation =
      create(*client, "Lsystem: 1\nderivation length: 12\nAxiom: A(1)\nA(x) --> A(x)A(x)\nendlsystem\n");
  resultOf(client->request("simulation.run", named(simulation)));
  const std::string memory = member(resultOf(client->request("server.status", "{}")), "memory");
  // 4096 modules of two bytes and a double each, in the string that is read and in the one that is written
  EXPECT_EQ(member(memory, "stringBytes"), "81920");
  EXPECT_GT(std::stoull(member(memory, "storeBytes")), std::stoull(member(empty, "storeBytes")));
}

TEST(Server, SetGivesVariablesAndDefinitionsOtherValues) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation =
      create(*client,
             "#define GROWTH 1\nLsystem: 1\nderivation length: 9\nStart: {size = 1;}\nAxiom: A\n"
             "A : {size = size + GROWTH;} * --> F(size)A\nendlsystem\n");
  const auto set = [&](const std::string& values) {
    return client->request("simulation.set", named(simulation, "\"parameters\":" + values));
  };
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(member(resultOf(set(R"({"size":10})")), "step"), "1");
  resultOf(client->request("simulation.step", named(simulation)));
  resultOf(set(R"({"GROWTH":5})"));
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(stringOf(*client, simulation), "F(2)F(11)F(16)A");
  EXPECT_EQ(
      errorOf(set(R"({"GROWHT":5})")).message,
      "params.parameters.GROWHT: the model has neither a variable nor a #define of that name. Did you mean 'GROWTH'?");
  EXPECT_EQ(errorOf(set(R"({"light":5})")).message,
            "params.parameters.light: the model has neither a variable nor a #define of that name");
  EXPECT_EQ(errorOf(set(R"({"size":"big"})")).message, "params.parameters.size: expected a number for a variable");
  EXPECT_EQ(errorOf(set(R"({"size":1,"GROWTH":2})")).message,
            "params.parameters: variables and #defines in one call could fail half-way; set them one after the other");
  // a definition that does not compile changes nothing
  EXPECT_EQ(static_cast<int>(errorOf(set(R"({"GROWTH":"+*"})")).code), 1009);
  EXPECT_EQ(stringOf(*client, simulation), "F(2)F(11)F(16)A");
}

TEST(Server, EditPrunesAndBendsBetweenSteps) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  std::string simulation;
  {
    const RunningServer server(options);
    const auto client = connectTo(server);
    simulation = create(*client, "Lsystem: 1\nderivation length: 9\nAxiom: F(1)[+(30)A]A\nA --> F(1)A\nendlsystem\n");
    resultOf(client->request("simulation.step", named(simulation)));
    EXPECT_EQ(member(resultOf(client->request("simulation.edit", named(simulation, R"("module":3,"action":"prune")"))),
                     "step"),
              "1");
    resultOf(client->request(
        "simulation.edit",
        named(simulation, R"("module":4,"action":"insert","modules":[{"symbol":"+","parameters":[5]}])")));
    EXPECT_EQ(stringOf(*client, simulation), "F(1)[+(30)]+(5)F(1)A");
    EXPECT_EQ(errorOf(client->request("simulation.edit", named(simulation, R"("module":4,"action":"bend")"))).message,
              "params.action: expected one of insert, prune, replace, found \"bend\"");
    EXPECT_EQ(
        member(errorOf(client->request("simulation.edit", named(simulation, R"("module":40,"action":"prune")"))).data,
               "step"),
        "1");
  }
  const RunningServer server(options);
  const auto client = connectTo(server);
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(stringOf(*client, simulation), "F(1)[+(30)]+(5)F(1)F(1)A");
}

TEST(Server, ACreationCanBeCancelled) {
  ServerOptions options;
  options.limits.simulation.maximumLoopIterations = UINT64_MAX;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const auto id = client
                      ->send("simulation.create", createParams("Lsystem: 1\nStart: {i = 0; while (i < 1000000000000) "
                                                               "{i = i + 1;}}\nAxiom: A\nA --> A\nendlsystem\n"))
                      .value();
  cancelAndExpectIt(*client, id);
  EXPECT_EQ(member(resultOf(client->request("simulation.list", "{}")), "simulations"), "[]");
}

TEST(Server, OthersAreServedWhileALongRunGoesOn) {
  const RunningServer server;
  const auto runner = connectTo(server);
  const std::string simulation =
      create(*runner, "Lsystem: 1\nderivation length: 100000000\nAxiom: A\nA --> A\nendlsystem\n");
  const auto id = runner->send("simulation.run", named(simulation)).value();
  const auto other = connectTo(server);
  EXPECT_EQ(stringOf(*other, simulation), "A");
  EXPECT_FALSE(runner->notify("$/cancel", "{\"id\":" + std::to_string(id) + "}").has_value());
  EXPECT_EQ(static_cast<int>(errorOf(runner->waitFor(id, std::chrono::seconds(30))).code), 1010);
}

}  // namespace
}  // namespace espalier::server::server_test

#include <gtest/gtest.h>

#include <future>

#include "engine/core/check.h"
#include "engine/language/compiler.h"
#include "server/remote/hosting/environment_dialogue.h"
#include "server/server_core.h"
#include "server/session/session.h"
#include "tests/server/server_fixture.h"

// the errors that only a bug or a moment brings about; the others are tested where they arise
namespace espalier::server::error_numbers_test {
namespace {

/// Keeps what a session sends.
class KeptConnection final : public Connection {
 public:
  void send(std::shared_ptr<const std::string> line) override { lines.push_back(*line); }
  void closeWhenSent() override {}
  void remind(std::chrono::milliseconds) override {}
  [[nodiscard]] std::size_t outboxBytes() const override { return 0; }
  [[nodiscard]] std::string peerName() const override { return "test"; }
  std::vector<std::string> lines;
};

ServerOptions quietOptions() {
  ServerOptions options;
  options.logLevel = "off";
  options.workers = 1;
  return options;
}

/// A process with a bug.
class Buggy final : public turtle::EnvironmentProcess {
 public:
  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return {}; }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch&) override {
    ESPALIER_CHECK(queries.size() == 99);
    return std::nullopt;
  }
};

TEST(ErrorNumbers, ABugInAnEnvironmentIsInternal) {
  const ProcessFactory factory = [] { return std::make_unique<Buggy>(); };
  EnvironmentDialogue dialogue(factory, {});
  const auto answer = dialogue.answer(protocol::decodeMessage(
      R"({"jsonrpc":"2.0","id":1,"method":"environment.step","params":{"simulation":"s","step":0,)"
      R"("queries":[{"id":0,"symbol":"E"}]}})"));
  const std::string error = member(answer.value_or("{}"), "error");
  EXPECT_EQ(member(error, "code"), "-32603");
  EXPECT_NE(member(error, "message").find("The environment has a bug: "), std::string::npos);
}

TEST(EnvironmentDialogue, AnswersPingAtOnce) {
  const ProcessFactory factory = [] { return std::make_unique<Buggy>(); };
  EnvironmentDialogue dialogue(factory, {});
  EXPECT_EQ(dialogue.answer(protocol::decodeMessage(R"({"jsonrpc":"2.0","id":"h1","method":"ping"})")).value_or(""),
            "{\"jsonrpc\":\"2.0\",\"id\":\"h1\",\"result\":{}}\n");
}

TEST(ErrorNumbers, ABugInACommandIsInternalAndClosesThatSimulationOnly) {
  ServerCore core(quietOptions());
  const auto make = [&core]() {
    SimulationRecord record;
    record.id = core.reserve("1", "local").value();
    core::MemoryFileProvider files({{"model.l", std::string(kGrowth)}});
    language::CompileInput input;
    input.modelFile = "model.l";
    Interruption interruption;
    auto made =
        HostedSimulation::create(record, {language::compile(input, files).program}, {}, core.limits().simulation,
                                 core.environmentServices(core.accounts().of("")), core.store(), interruption);
    core.add(record.id, std::move(made.value()));
    return core.find(record.id);
  };
  const auto broken = make();
  const auto other = make();
  const auto outcomeOf = [](SimulationRunner& runner, bool isBuggy) {
    std::promise<protocol::Error> outcome;
    auto command = std::make_shared<Command>();
    command->owner = "test";
    command->advance = [&outcome, isBuggy](SimulationRunner&, Command&) {
      ESPALIER_CHECK(!isBuggy);
      outcome.set_value({protocol::ErrorCode::Parse, "done", {}});
      return false;
    };
    command->fail = [&outcome](const protocol::Error& error) { outcome.set_value(error); };
    runner.submit(command);
    return outcome.get_future().get();
  };
  const protocol::Error error = outcomeOf(*broken, true);
  EXPECT_EQ(static_cast<int>(error.code), -32603);
  EXPECT_NE(error.message.find("Espalier has a bug: "), std::string::npos);
  EXPECT_NE(error.message.find("This simulation is closed; please report it."), std::string::npos);
  EXPECT_EQ(static_cast<int>(outcomeOf(*broken, false).code), -32603);
  EXPECT_EQ(outcomeOf(*other, false).message, "done");
}

TEST(ErrorNumbers, AServerThatStopsBeginsNothing) {
  ServerCore core(quietOptions());
  const auto connection = std::make_shared<KeptConnection>();
  const auto session = std::make_shared<Session>("1", core, connection);
  const auto say = [&](const std::string& line) {
    session->onRead(protocol::decodeMessage(line));
    return connection->lines.back();
  };
  const std::string hello = say(R"({"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1]}})");
  EXPECT_EQ(member(member(hello, "result"), "protocol"), "1");
  core.beginShutdown();
  const std::string error = member(say(R"({"jsonrpc":"2.0","id":2,"method":"server.status"})"), "error");
  EXPECT_EQ(member(error, "code"), "1015");
  EXPECT_EQ(member(error, "message"), "The server is shutting down. Ask again when it is back.");
}

TEST(ErrorNumbers, WithoutADataFolderThereAreNoCheckpoints) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kGrowth, R"([{"type":"height"}])");
  const auto error = errorOf(client->request("simulation.save", named(simulation, R"("checkpoint":"a")")));
  EXPECT_EQ(static_cast<int>(error.code), 1014);
  EXPECT_NE(error.message.find("Start it with --data DIR"), std::string::npos) << error.message;
}

}  // namespace
}  // namespace espalier::server::error_numbers_test

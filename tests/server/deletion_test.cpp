// Simulations that are deleted while they compute.
#include <condition_variable>
#include <future>
#include <mutex>
#include <vector>

#include "server/server_core.h"
#include "server/session/session.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::deletion_test {
namespace {

/// Keeps what a session sends, until a thread asks for it.
class Answers final : public Connection {
 public:
  void send(std::shared_ptr<const std::string> line) override {
    const std::lock_guard lock(mutex_);
    lines_.push_back(*line);
    changed_.notify_all();
  }
  void closeWhenSent() override {}
  void remind(std::chrono::milliseconds) override {}
  [[nodiscard]] std::size_t outboxBytes() const override { return 0; }
  [[nodiscard]] std::string peerName() const override { return "test"; }

  /// The next line, or "{}" when none comes.
  std::string next() {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, std::chrono::seconds(60), [this] { return read_ < lines_.size(); })) {
      ADD_FAILURE() << "no answer came";
      return "{}";
    }
    return lines_[read_++];
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::string> lines_;
  std::size_t read_ = 0;
};

class Caller {
 public:
  Caller(ServerCore& core, const std::string& id) : session_(std::make_shared<Session>(id, core, answers_)) {
    ask(R"({"jsonrpc":"2.0","id":1,"method":"hello","params":{"protocol":[1]}})");
  }
  void send(const std::string& line) { session_->onRead(protocol::decodeMessage(line)); }
  std::string answer() { return answers_->next(); }
  std::string ask(const std::string& line) {
    send(line);
    return answer();
  }
  /// simulation.create under the one name of these tests.
  std::string create() {
    return ask(R"({"jsonrpc":"2.0","id":2,"method":"simulation.create","params":)" +
               createParams(kGrowth, "[]", R"("simulation":"sim-5d03a1c7e2b4")") + "}");
  }
  void sendDelete() {
    send(R"({"jsonrpc":"2.0","id":3,"method":"simulation.delete","params":{"simulation":"sim-5d03a1c7e2b4"}})");
  }

 private:
  std::shared_ptr<Answers> answers_ = std::make_shared<Answers>();
  std::shared_ptr<Session> session_;
};

class Deletion : public testing::Test {
 protected:
  Deletion() { EXPECT_EQ(core_.loadSaved(), std::nullopt); }

  /// A turn that lasts until the test ends it, whatever gives it up.
  void beginLongTurn() {
    auto command = std::make_shared<Command>();
    command->owner = "test";
    command->advance = [this, end = end_.get_future().share()](SimulationRunner&, Command&) {
      begun_.set_value();
      end.wait();
      return false;
    };
    command->fail = [](const protocol::Error&) {};
    core_.find("sim-5d03a1c7e2b4")->submit(command);
    begun_.get_future().wait();
  }
  void endLongTurn() { end_.set_value(); }
  [[nodiscard]] std::size_t saved() const { return core_.store().simulations().value().size(); }

  static ServerOptions options(const std::string& folder) {
    ServerOptions options;
    options.logLevel = "off";
    options.workers = 2;
    options.dataFolder = folder;
    return options;
  }

  TemporaryFolder folder_;
  std::promise<void> begun_;
  std::promise<void> end_;
  ServerCore core_{options(folder_.path())};
};

TEST_F(Deletion, NobodyGetsTheIdentifierBeforeTheLastTurnIsOver) {
  Caller first(core_, "1");
  Caller second(core_, "2");
  EXPECT_EQ(member(member(first.create(), "result"), "step"), "0");
  beginLongTurn();
  first.sendDelete();
  const std::string refused = member(second.create(), "error");
  EXPECT_EQ(member(refused, "message"), "The simulation was deleted.");
  endLongTurn();
  EXPECT_EQ(member(first.answer(), "result"), "{}");
  EXPECT_EQ(saved(), 0U);
  EXPECT_EQ(member(member(second.create(), "result"), "step"), "0");
  EXPECT_EQ(saved(), 1U);
}

TEST_F(Deletion, GoesOnWithoutTheCaller) {
  {
    Caller caller(core_, "1");
    EXPECT_EQ(member(member(caller.create(), "result"), "step"), "0");
    EXPECT_EQ(saved(), 1U);
    beginLongTurn();
    caller.sendDelete();
  }
  endLongTurn();
  core_.waitForWorkers();
  EXPECT_EQ(saved(), 0U);
}

TEST(DeletionOfEnvironments, AnEnvironmentIsToldThatItsSimulationIsNoMore) {
  const RunningServer server;
  const auto client = connectTo(server);
  std::promise<std::string> closed;
  const OfferingEnvironment environment(
      server, "told", [&](client::Client& self, const client::IncomingRequest& request) {
        if (request.method == "environment.close") {
          closed.set_value(member(request.params.toText(), "simulation"));
        }
        (void)self.respond(request.id, request.method == "environment.step" ? R"({"replies":[]})" : "{}");
      });
  const std::string simulation = create(*client, kGrowth, R"([{"type":"offered","name":"told"}])");
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(resultOf(client->request("simulation.delete", named(simulation))), "{}");
  EXPECT_EQ(closed.get_future().get(), simulation);
}

}  // namespace
}  // namespace espalier::server::deletion_test

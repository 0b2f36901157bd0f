#include "server/running/simulation_runner.h"

#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <thread>

#include "engine/language/compiler.h"
#include "server/server_core.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::simulation_runner_test {
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

/// Something that a thread waits for and a test lets happen.
class Gate {
 public:
  void open() { promise_.set_value(); }
  void wait() const { future_.wait(); }

 private:
  std::promise<void> promise_;
  std::shared_future<void> future_ = promise_.get_future().share();
};

/// A simulation without a network, whose turns a test holds.
class HeldTurns : public testing::Test {
 protected:
  static ServerOptions options() {
    ServerOptions options;
    options.logLevel = "off";
    options.workers = 4;
    options.limits.callSeconds = 1;
    return options;
  }

  HeldTurns() {
    SimulationRecord record;
    record.id = core_.reserve("1", "owner").value();
    core::MemoryFileProvider files;
    files.add("model.l", "Lsystem: 1\nderivation length: 3\nAxiom: A\nA --> A\nendlsystem\n");
    language::CompileInput input;
    input.modelFile = "model.l";
    Interruption interruption;
    auto made =
        HostedSimulation::create(record, {language::compile(input, files).program}, {}, core_.limits().simulation,
                                 core_.environmentServices(core_.accounts().of("")), core_.store(), interruption);
    core_.add(record.id, std::move(made.value()));
    runner_ = core_.find(record.id);
  }
  ~HeldTurns() override { core_.waitForWorkers(); }

  /// A turn that begins, and goes on until the test opens its gate.
  struct Turn {
    Gate begun, ended;
    std::shared_ptr<Command> command = std::make_shared<Command>();
  };
  void submit(Turn& turn) {
    turn.command->advance = [&turn](SimulationRunner& runner, Command&) {
      turn.begun.open();
      turn.ended.wait();
      double milliseconds = 0.0;
      // work that was given up makes no step
      EXPECT_EQ(runner.hosted().step(milliseconds).has_value(), turn.command->isOverLimit.load());
      return false;
    };
    turn.command->fail = [](const protocol::Error&) {};
    runner_->submit(turn.command);
    turn.begun.wait();
  }
  /// The same of a task that has no simulation, with something that happens at its limit.
  struct Task {
    Gate begun, ended, atLimit, goOn;
  };
  void post(Task& task, std::chrono::milliseconds limit) {
    core_.pool().post({.run =
                           [&task] {
                             task.begun.open();
                             task.ended.wait();
                           },
                       .lane = Lane::Step,
                       .owner = "test",
                       .limit = limit,
                       .onLimit =
                           [&task] {
                             task.atLimit.open();
                             task.goOn.wait();
                           }});
    task.begun.wait();
  }
  static void waitUntilOver(std::chrono::seconds limit) {
    const auto end = std::chrono::steady_clock::now() + limit;
    while (std::chrono::steady_clock::now() <= end) {
      std::this_thread::yield();
    }
  }

  ServerCore core_{options()};
  std::shared_ptr<SimulationRunner> runner_;
};

TEST_F(HeldTurns, TheLimitOfATurnThatHasEndedDoesNotGiveUpTheNextOne) {
  // the thread that looks after limits is held until two tasks are over theirs; then it tells one after the other
  Task holding, earlier;
  post(holding, std::chrono::milliseconds(1));
  holding.atLimit.wait();
  post(earlier, std::chrono::seconds(1));
  Turn first, second;
  submit(first);
  waitUntilOver(std::chrono::seconds(1));
  holding.goOn.open();
  earlier.atLimit.wait();
  // it is about to give up the first turn, which ends now; another one begins
  first.ended.open();
  submit(second);
  earlier.goOn.open();
  // it has told everybody when it comes to the next task
  Task last;
  post(last, std::chrono::milliseconds(1));
  last.atLimit.wait();
  EXPECT_FALSE(second.command->isOverLimit);
  last.goOn.open();
  // a turn over its own limit is given up
  waitUntilOver(std::chrono::seconds(1));
  while (!second.command->isOverLimit) {
    std::this_thread::yield();
  }
  second.ended.open();
  for (Task* const task : {&holding, &earlier, &last}) {
    task->ended.open();
  }
  core_.waitForWorkers();
}

}  // namespace
}  // namespace espalier::server::simulation_runner_test

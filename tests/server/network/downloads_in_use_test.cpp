// Downloads of a simulation that goes on.
#include <future>

#include "engine/language/compiler.h"
#include "server/network/downloads.h"
#include "server/server_core.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::downloads_in_use_test {
namespace {

constexpr std::string_view kBush =
    "Lsystem: 1\nderivation length: 6\nAxiom: A\nA --> F(1)[+(30)A][-(30)A]/(90)A\nendlsystem\n";

class DownloadsInUse : public testing::Test {
 protected:
  static ServerOptions options() {
    ServerOptions options;
    options.logLevel = "off";
    options.workers = 1;
    return options;
  }

  DownloadsInUse() {
    SimulationRecord record;
    record.id = core_.reserve("1", "owner").value();
    record.owner = "owner";
    core::MemoryFileProvider files({{"model.l", std::string(kBush)}});
    language::CompileInput input;
    input.modelFile = "model.l";
    Interruption interruption;
    auto made =
        HostedSimulation::create(record, {language::compile(input, files).program}, {}, core_.limits().simulation,
                                 core_.environmentServices(core_.accounts().of("")), core_.store(), interruption);
    core_.add(record.id, std::move(made.value()));
    name_ = record.id;
  }
  ~DownloadsInUse() override { core_.waitForWorkers(); }

  /// Has the simulation do `work` in a turn of its own.
  std::future<void> inTurn(std::function<void(SimulationRunner&)> work) {
    auto done = std::make_shared<std::promise<void>>();
    auto command = std::make_shared<Command>();
    command->owner = "test";
    command->advance = [done, work = std::move(work)](SimulationRunner& runner, Command&) {
      work(runner);
      done->set_value();
      return false;
    };
    command->fail = [](const protocol::Error&) {};
    core_.find(name_)->submit(command);
    return done->get_future();
  }
  void step() {
    inTurn([](SimulationRunner& runner) {
      double milliseconds = 0.0;
      EXPECT_EQ(runner.hosted().step(milliseconds), std::nullopt);
    }).wait();
  }
  std::function<void()> ask(const std::string& file, std::function<void(HttpPage)> done) {
    return makeDownload(core_, core_.accounts().of("viewer"), {DownloadPath::Kind::Export, name_, file},
                        std::move(done));
  }

  ServerCore core_{options()};
  std::string name_;
};

TEST_F(DownloadsInUse, AnExportIsOfTheStateThatWasAskedForAndStepsGoOnMeanwhile) {
  step();
  const auto textOf = [this] {
    std::promise<std::string> page;
    (void)ask("plant.obj", [&](HttpPage made) { page.set_value(made.body); });
    return page.get_future().get();
  };
  const std::string expected = textOf();
  EXPECT_NE(expected.find("\nf "), std::string::npos);
  // the download is not over before `end`
  std::promise<void> begun;
  std::promise<void> end;
  std::promise<std::string> page;
  (void)ask("plant.obj", [&, ended = end.get_future().share()](HttpPage made) {
    begun.set_value();
    ended.wait();
    page.set_value(made.body);
  });
  begun.get_future().wait();
  step();
  end.set_value();
  EXPECT_EQ(page.get_future().get(), expected);
  EXPECT_NE(textOf(), expected);
}

TEST_F(DownloadsInUse, WhoDownloadsPays) {
  for (int i = 0; i < 6; ++i) {
    step();
  }
  core_.waitForWorkers();
  const double owner = core_.accounts().of("owner").cpuSeconds();
  std::promise<std::string> page;
  (void)ask("plant.usda", [&](HttpPage made) { page.set_value(made.body); });
  EXPECT_GT(page.get_future().get().size(), 100'000U);
  core_.waitForWorkers();
  const double paid = core_.accounts().of("viewer").cpuSeconds();
  EXPECT_GT(paid, 0.0);
  EXPECT_LT(core_.accounts().of("owner").cpuSeconds() - owner, paid);
}

TEST_F(DownloadsInUse, WhatIsGivenUpIsNotMadeAndAnAccountHasFewAtATime) {
  std::promise<void> hold;
  const auto held = hold.get_future().share();
  const auto turn = inTurn([held](SimulationRunner&) { held.wait(); });
  std::atomic<int> made{0};
  std::vector<std::function<void()>> giveUps;
  for (int i = 0; i < 8; ++i) {
    giveUps.push_back(ask("plant.obj", [&](const HttpPage&) { ++made; }));
  }
  HttpPage refused;
  (void)ask("plant.obj", [&](HttpPage page) { refused = std::move(page); });
  EXPECT_EQ(refused.status, 503U);
  EXPECT_NE(refused.body.find("downloads 8 files now"), std::string::npos) << refused.body;
  for (const auto& giveUp : giveUps) {
    giveUp();
  }
  giveUps.clear();
  hold.set_value();
  inTurn([](SimulationRunner&) {}).wait();
  core_.waitForWorkers();
  EXPECT_EQ(made, 0);
  std::promise<unsigned> status;
  (void)ask("plant.obj", [&](const HttpPage& page) { status.set_value(page.status); });
  EXPECT_EQ(status.get_future().get(), 200U);
}

}  // namespace
}  // namespace espalier::server::downloads_in_use_test

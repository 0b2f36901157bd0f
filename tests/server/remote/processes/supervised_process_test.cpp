#include "server/remote/processes/supervised_process.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "environment/environment_set.h"
#include "environment/registry.h"
#include "server/remote/processes/plugin_library.h"
#include "tests/support/places.h"

namespace espalier::server::supervised_process_test {
namespace {

using Process = std::unique_ptr<turtle::EnvironmentProcess>;

const std::string kLibrary = buildFolder() + "/lib/misbehaving.so";

std::shared_ptr<const language::Program> compiled(const std::string& text) {
  core::MemoryFileProvider files;
  files.add("model.l", text);
  language::CompileInput input;
  input.modelFile = "model.l";
  auto result = language::compile(input, files);
  EXPECT_NE(result.program, nullptr);
  return result.program;
}

/// The plug-in misbehaves in step 3 as long as the file is there.
class Misbehaviour : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    file_ = std::filesystem::temp_directory_path() / (std::string("espalier-") + test->name());
    std::ofstream(file_) << "here";
  }
  void TearDown() override { mend(); }
  void mend() const { std::filesystem::remove(file_); }

  [[nodiscard]] Process plugin(const std::string& does, int milliseconds = 60'000) const {
    const std::string configuration = R"({"does":")" + does + R"(","in":3,"while":")" + file_.string() + R"("})";
    auto loaded = loadPluginProcess(kLibrary, configuration, std::chrono::milliseconds(milliseconds));
    if (!loaded) {
      ADD_FAILURE() << loaded.error();
      return nullptr;
    }
    return std::move(loaded.value());
  }

  /// Grows a plant to step 2, sees step 3 fail with the message, twice, and grows on once the plug-in is mended. What
  /// the plug-in answers is how often it has advanced, so nothing was lost and nothing was done twice.
  void expectNothingLost(Process environment, const std::string& message) const {
    simulation::Simulation simulation(compiled("Lsystem: 1\nderivation length: 5\nAxiom: A?E(0)\n"
                                               "A > ?E(x) --> F(x)A\nendlsystem\n"),
                                      {{}}, std::move(environment), {});
    ASSERT_FALSE(simulation.rewind().has_value());
    for (int step = 0; step < 2; ++step) {
      const auto error = simulation.step();
      ASSERT_FALSE(error.has_value()) << error->message;
    }
    const std::string before = simulation.stringText();
    const std::uint64_t hash = simulation.stateHash();
    for (int attempt = 0; attempt < 2; ++attempt) {
      const auto error = simulation.step();
      ASSERT_TRUE(error.has_value());
      EXPECT_EQ(error->code, core::SimulationErrorCode::EnvironmentFailed);
      EXPECT_EQ(error->step, 3U);
      EXPECT_EQ(error->message, message + (message.back() == '.' ? "" : ".") + " The simulation stays at step 2.");
      EXPECT_EQ(simulation.completedSteps(), 2U);
      EXPECT_EQ(simulation.stringText(), before);
      EXPECT_EQ(simulation.stateHash(), hash);
    }
    mend();
    while (!simulation.isFinished()) {
      const auto error = simulation.step();
      ASSERT_FALSE(error.has_value()) << error->message;
    }
    EXPECT_EQ(simulation.stringText(), "F(1)F(2)F(3)F(4)F(5)A?E(5)");
  }

  std::filesystem::path file_;
};

const std::string kHangs =
    "environment 'misbehaving' did not finish step 3 within 50 ms. It runs inside this program and cannot be stopped "
    "from outside: that call is left alone, and a new instance answers from now on. Correct it, give it longer, or run "
    "it as a program of its own.";

TEST_F(Misbehaviour, APluginThatThrowsFailsTheStepAndGoesOnWhenMended) {
  expectNothingLost(plugin("throw"), "environment 'misbehaving' failed with an exception: the well is dry.");
}

TEST_F(Misbehaviour, APluginThatThrowsWhatIsNoExceptionToo) {
  expectNothingLost(plugin("throwNothing"), "environment 'misbehaving' failed with an exception that says nothing.");
}

TEST_F(Misbehaviour, APluginThatHangsFailsTheStepAndANewInstanceGoesOn) {
  expectNothingLost(plugin("hang", 50), kHangs);
}

TEST_F(Misbehaviour, APluginThatAnswersNoNumberFailsTheStepAndGoesBack) {
  expectNothingLost(plugin("nan"),
                    "environment 'misbehaving' answered nan for parameter 1 of query 0 (plant 0, module 4). Replies "
                    "must be finite numbers: correct the environment.");
}

TEST_F(Misbehaviour, APluginThatSaysThatItFails) {
  expectNothingLost(plugin("fail"), "environment plug-in 'misbehaving' failed in step: it is not my day");
}

TEST_F(Misbehaviour, ACompanionIsAsBeforeToo) {
  // numbers are added to the counts once only
  for (const std::string does : {"throw", "nan", "hang"}) {
    std::ofstream(file_) << "here";
    std::vector<std::pair<std::string, Process>> processes;
    auto soil = environment::makeProcess("density3d", R"({"range":[9,9,9]})");
    processes.emplace_back("Counts", std::move(soil.value()));
    processes.emplace_back("Bad", plugin(does, 50));
    simulation::Simulation simulation(
        compiled("Module: ?Counts(x), ?Bad(x)\nLsystem: 1\nderivation length: 4\nAxiom: A?Counts(1)?Bad(0)\n"
                 "A > ?Counts(x) --> F(x)A\n?Counts(x) --> ?Counts(1)\nendlsystem\n"),
        {{}}, environment::makeEnvironmentSet(std::move(processes)), {});
    ASSERT_FALSE(simulation.rewind().has_value());
    int failures = 0;
    while (!simulation.isFinished()) {
      if (simulation.step()) {
        ASSERT_EQ(++failures, 1) << does;
        ASSERT_EQ(simulation.completedSteps(), 2U);
        mend();
      }
    }
    EXPECT_EQ(failures, 1) << does;
    EXPECT_EQ(simulation.stringText(), "F(1)F(2)F(3)F(4)A?Counts(1)?Bad(4)") << does;
  }
}

TEST(SupervisedProcess, ABuiltInProcessAnswersTheSameWhenItIsWatched) {
  const std::string configuration = R"({"domainSize":[10,10,10],"gridSize":[5,5,5],"depletion":true})";
  const auto make = [&configuration]() { return std::move(environment::makeProcess("soil", configuration).value()); };
  const auto watched = supervised(make(), {.stepTimeout = std::chrono::seconds(60), .again = make});
  const Process plain = make();
  turtle::QueryBatch queries;
  queries.plant = {0, 0};
  queries.module = {1, 2};
  queries.symbol = {0, 0};
  queries.position = {{1.0, 1.0, 1.0}, {9.0, 2.5, 9.0}};
  queries.heading = queries.left = queries.up = queries.position;
  queries.parameterOffset = {0, 1, 2};
  queries.parameters = {0.5, 0.25};
  for (auto* process : {watched.get(), plain.get()}) {
    ASSERT_FALSE(process->open({}).has_value());
  }
  for (std::uint64_t step = 0; step < 3; ++step) {
    queries.step = step;
    turtle::ReplyBatch one;
    turtle::ReplyBatch other;
    one.prepare(queries);
    other.prepare(queries);
    ASSERT_FALSE(watched->step(queries, one).has_value());
    ASSERT_FALSE(plain->step(queries, other).has_value());
    EXPECT_EQ(one.values, other.values);
    EXPECT_EQ(one.isSet, other.isSet);
    EXPECT_EQ(one.answeredCount, other.answeredCount);
    ASSERT_FALSE(watched->tick(step).has_value());
    ASSERT_FALSE(plain->tick(step).has_value());
    EXPECT_EQ(watched->save(), plain->save());
  }
}

}  // namespace
}  // namespace espalier::server::supervised_process_test

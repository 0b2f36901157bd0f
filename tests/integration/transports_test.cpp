#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "environment/registry.h"
#include "server/remote/disk_files.h"
#include "server/remote/processes/line_channel.h"
#include "server/remote/remote_environment.h"
#include "tests/support/places.h"

namespace espalier::transports_test {
namespace {

constexpr const char* kHonda = R"({"radius":0.5})";
constexpr const char* kShadow = R"({"gridSize":101,"gridSpan":50})";  // as the model's .spec: voxels of side 1

std::shared_ptr<const language::Program> galleryProgram(const std::string& name) {
  const std::string stem = sourceFolder() + "/clients/gallery/" + name + "/" + name;
  server::DiskFileProvider files;
  language::CompileInput input;
  input.modelFile = stem + ".l";
  input.viewFile = stem + ".v";
  return language::compile(input, files).program;
}

std::unique_ptr<turtle::EnvironmentProcess> builtIn(const std::string& name, const std::string& configuration) {
  auto made = environment::makeProcess(name, configuration);
  return made ? std::move(*made) : nullptr;
}

const std::string kProgram = buildFolder() + "/bin/espalier";

std::unique_ptr<turtle::EnvironmentProcess> connected(const std::string& address, bool isTextOnly) {
  server::RemoteEnvironmentOptions options;
  options.isTextOnly = isTextOnly;
  auto made = server::connectRemoteEnvironment(address, options);
  if (!made) {
    ADD_FAILURE() << made.error();
    return nullptr;
  }
  return std::move(*made);
}

std::unique_ptr<turtle::EnvironmentProcess> spawned(const std::string& arguments, bool isTextOnly = false) {
  return connected("stdio:'" + kProgram + "' environment " + arguments + " --stdio", isTextOnly);
}

/// A built-in served by a process of its own on a free port of this machine.
class Listening {
 public:
  explicit Listening(const std::string& arguments) {
    auto result =
        server::ChildProcess::start("exec '" + kProgram + "' environment " + arguments + " --listen 127.0.0.1:0");
    started_ = std::move(result.value());
    server::LineChannel channel(std::move(started_->input), std::move(started_->output), 1'000);
    std::string line;
    EXPECT_EQ(channel.readLine(line, std::chrono::steady_clock::now() + std::chrono::seconds(30)),
              server::LineChannel::Status::Done);
    address_ = "tcp://" + line.substr(line.rfind(' ') + 1);
  }
  ~Listening() { started_->process.end(); }
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;
  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  std::unique_ptr<server::ChildProcess::Started> started_;
  std::string address_;
};

std::unique_ptr<simulation::Simulation> grown(const std::string& model,
                                              std::unique_ptr<turtle::EnvironmentProcess> environment,
                                              unsigned threads = 1) {
  simulation::SimulationOptions options;
  options.threads = threads;
  auto result = std::make_unique<simulation::Simulation>(galleryProgram(model), std::vector<turtle::PlantPlacement>(1),
                                                         std::move(environment), std::move(options));
  EXPECT_FALSE(result->rewind().has_value());
  return result;
}

void expectSamePlantInEveryStep(simulation::Simulation& one, simulation::Simulation& other) {
  ASSERT_FALSE(one.isFinished());
  while (!one.isFinished()) {
    ASSERT_FALSE(one.step().has_value());
    ASSERT_FALSE(other.step().has_value());
    ASSERT_EQ(one.stringText(), other.stringText()) << "step " << one.completedSteps();
    ASSERT_EQ(one.statistics().answers, other.statistics().answers);
    ASSERT_EQ(one.stateHash(), other.stateHash()) << "step " << one.completedSteps();
  }
  EXPECT_TRUE(other.isFinished());
  EXPECT_GT(one.statistics().answers, 0U);
}

TEST(Transports, ASpawnedHeightGivesTheSamePlantInEveryStep) {
  const auto inside = grown("growth-to-a-height", builtIn("height", ""));
  const auto outside = grown("growth-to-a-height", spawned("height"));
  expectSamePlantInEveryStep(*inside, *outside);
  EXPECT_EQ(inside->stringText(), "F(0,0)F(0,1)F(0,2)?E(2)");
}

TEST(Transports, ASpawnedShadowGivesTheSamePlantInEveryStepWithSeveralThreads) {
  // light and gradients are doubles with all their bits: a rounded one would show in the parameters
  const std::string file = ::testing::TempDir() + "espalier-transports-shadow.json";
  std::ofstream(file) << kShadow;
  const auto inside = grown("shadow-trees", builtIn("shadow", kShadow));
  const auto outside = grown("shadow-trees", spawned("shadow --configuration '" + file + "'"), 3);
  expectSamePlantInEveryStep(*inside, *outside);
  EXPECT_GT(outside->string().size(), 10'000U);
}

TEST(Transports, TextAndBlocksOverStdioAndTcpGiveTheSameStateHashInEveryStep) {
  // an environment without state, and one whose state is part of the hash
  const std::string file = ::testing::TempDir() + "espalier-transports-shadow.json";
  std::ofstream(file) << kShadow;
  struct Case {
    std::string model, process, configuration, arguments;
  };
  for (const Case& c : {Case{"branch-tiers", "honda", kHonda,
                             "honda --configuration '" + (::testing::TempDir() + "espalier-honda.json") + "'"},
                        Case{"shadow-trees", "shadow", kShadow, "shadow --configuration '" + file + "'"}}) {
    std::ofstream(::testing::TempDir() + "espalier-honda.json") << kHonda;
    const Listening listening(c.arguments);
    for (const bool isTextOnly : {false, true}) {
      SCOPED_TRACE(c.model + (isTextOnly ? " text" : " blocks"));
      const auto inside = grown(c.model, builtIn(c.process, c.configuration));
      const auto overPipes = grown(c.model, spawned(c.arguments, isTextOnly), 2);
      expectSamePlantInEveryStep(*inside, *overPipes);
      const auto again = grown(c.model, builtIn(c.process, c.configuration));
      const auto overTcp = grown(c.model, connected(listening.address(), isTextOnly), 4);
      expectSamePlantInEveryStep(*again, *overTcp);
    }
  }
}

TEST(Transports, ASnapshotContinuesAgainstTheSameProcessElsewhere) {
  const auto inside = grown("branch-tiers", builtIn("honda", kHonda));
  for (int step = 0; step < 4; ++step) {
    ASSERT_FALSE(inside->step().has_value());
  }
  core::StringSink snapshot;
  inside->save(snapshot);
  const auto continued = grown("branch-tiers", builtIn("honda", kHonda), 2);
  ASSERT_FALSE(continued->restore(snapshot.take()).has_value());
  EXPECT_EQ(continued->stateHash(), inside->stateHash());
  expectSamePlantInEveryStep(*inside, *continued);
  EXPECT_EQ(continued->stateHash(), inside->stateHash());
}

}  // namespace
}  // namespace espalier::transports_test

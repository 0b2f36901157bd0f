#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "environment/registry.h"
#include "server/disk_files.h"
#include "server/remote_environment.h"

namespace espalier {
namespace {

constexpr const char* kHonda = R"({"radius":0.5})";
constexpr const char* kShadow = R"({"gridSize":101,"gridSpan":50})";  // as the model's .spec: voxels of side 1

std::shared_ptr<const language::Program> galleryProgram(const std::string& name) {
  const std::string stem = std::string(ESPALIER_SOURCE_DIR) + "/clients/gallery/" + name + "/" + name;
  server::DiskFileProvider files;
  language::CompileInput input;
  input.modelFile = stem + ".l";
  input.viewFile = stem + ".v";
  return language::compile(input, files).program;
}

std::unique_ptr<turtle::EnvironmentProcess> builtIn(const std::string& name, const std::string& configuration) {
  auto made = environment::makeProcess(name, configuration);
  auto* process = std::get_if<std::unique_ptr<turtle::EnvironmentProcess>>(&made);
  return process == nullptr ? nullptr : std::move(*process);
}

std::unique_ptr<turtle::EnvironmentProcess> spawned(const std::string& arguments) {
  const std::string program = std::string(ESPALIER_BINARY_DIR) + "/bin/espalier";
  auto made = server::connectRemoteEnvironment("stdio:'" + program + "' environment " + arguments + " --stdio", {});
  if (const auto* error = std::get_if<std::string>(&made)) {
    ADD_FAILURE() << *error;
    return nullptr;
  }
  return std::move(std::get<std::unique_ptr<turtle::EnvironmentProcess>>(made));
}

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
}  // namespace espalier

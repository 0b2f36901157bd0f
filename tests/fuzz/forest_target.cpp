#include <algorithm>
#include <string>
#include <vector>

#include "engine/core/check.h"
#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "server/remote/translation/translate.h"
#include "tests/fuzz/bundle.h"
#include "tests/fuzz/small_limits.h"
#include "tests/fuzz/targets.h"

namespace espalier::fuzz {
namespace {

constexpr const char* kForest = "forest.json";
constexpr int kForestSteps = 3;
constexpr std::size_t kMostForestModels = 4;
constexpr std::size_t kMostPlants = 50;

/// The models of a forest; none when one of them is wrong.
simulation::Programs programsOf(const protocol::ForestParams& forest, core::FileProvider& files) {
  simulation::Programs programs;
  for (const protocol::NamedModel& model : forest.models) {
    language::CompileInput input;
    input.modelFile = model.file;
    input.limits = smallLimits();
    auto compiled = language::compile(input, files);
    if (compiled.program == nullptr) {
      return {};
    }
    programs.push_back(std::move(compiled.program));
  }
  return programs;
}

}  // namespace

void fuzzForest(std::string_view text) {
  core::MemoryFileProvider files = unbundle(text, kForest);
  // as the command line reads a file
  const std::string json = files.read(kForest).value_or("");
  if (protocol::jsonProblem(json)) {
    return;
  }
  const auto message = protocol::decodeMessage(R"({"jsonrpc":"2.0","method":"file","params":)" + json + "}");
  if (!message) {
    ESPALIER_CHECK(!message.error().error.message.empty());
    return;
  }
  const auto forest = protocol::decodeForestParams(message->payload);
  if (!forest) {
    ESPALIER_CHECK(!forest.error().message.empty());
    return;
  }
  simulation::SimulationOptions options;
  if (forest->world) {
    const auto world = server::toWorld(*forest->world);
    if (!world) {
      ESPALIER_CHECK(!world.error().empty());
      return;
    }
    options.world = *world;
  }
  if (forest->models.size() > kMostForestModels || forest->plants.size() > kMostPlants) {
    return;
  }
  const simulation::Programs programs = programsOf(*forest, files);
  std::vector<simulation::PlantOrigin> plants = server::plantOrigins(forest->models, forest->plants);
  if (programs.empty() || plants.empty()) {
    return;
  }
  options.limits = smallLimits();
  options.seed = forest->seed.value_or(1);
  options.hasSeed = true;
  options.derivationLength = kForestSteps;
  options.seeds = server::seedRules(forest->seeds);
  simulation::Simulation simulation(programs, std::move(plants), nullptr, options);
  if (simulation.rewind()) {
    return;
  }
  for (int step = 0; step < kForestSteps && !simulation.isFinished(); ++step) {
    const std::uint64_t before = simulation.stateHash();
    if (simulation.step()) {
      ESPALIER_CHECK(simulation.stateHash() == before);
      break;
    }
  }
  (void)simulation.scene();
}

}  // namespace espalier::fuzz

// Prints hashes of what models become: every bit of every state counts.
//
//   espalier_bits random FIRST COUNT THREADS    a line for every hundred models at random: random FIRST HASH
//   espalier_bits each FIRST COUNT THREADS      a line for each of them, to find one that differs
//   espalier_bits gallery FOLDER THREADS NAME...    models of the gallery: gallery NAME HASH

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "engine/core/hash.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "environment/registry.h"
#include "tests/bits/random_model.h"
#include "tests/support/disk_files.h"
#include "tests/support/model_environment.h"

namespace espalier::test {
namespace {

using Process = std::unique_ptr<turtle::EnvironmentProcess>;

constexpr std::uint32_t kBlock = 100;
constexpr std::uint64_t kMostModules = 400'000;  // of a model at random

struct Figures {
  std::uint32_t failures = 0;    // models that do not compile
  std::uint32_t unanswered = 0;  // models whose environment could not be made
  std::uint32_t stopped = 0;     // models with a step that failed
};

// adds the hash of the state after every step; a step that fails ends the run
void addRun(const std::shared_ptr<const language::Program>& program, Process process,
            simulation::SimulationOptions options, core::Hasher& hash, Figures& figures) {
  simulation::Simulation simulation(program, {turtle::PlantPlacement{}}, std::move(process), std::move(options));
  auto failure = simulation.rewind();
  while (!failure && !simulation.isFinished()) {
    failure = simulation.step();
    hash.integer(simulation.stateHash());
  }
  if (failure) {
    ++figures.stopped;
    hash.bytes(failure->message);
  }
}

std::shared_ptr<const language::Program> compiled(const std::string& model, const std::string& view,
                                                  core::FileProvider& files, Figures& figures) {
  language::CompileInput input;
  input.modelFile = model;
  input.viewFile = view;
  const language::CompileResult result = language::compile(input, files);
  figures.failures += result.program ? 0 : 1;
  return result.program;
}

void addRandomModel(std::uint32_t number, unsigned threads, core::Hasher& hash, Figures& figures) {
  const RandomModel model = randomModel(number);
  core::MemoryFileProvider files;
  files.add("model.l", model.text);
  files.add("model.v", model.view);
  const auto program = compiled("model.l", "model.v", files, figures);
  if (!program) {
    return;
  }
  Process process;
  if (!model.process.empty()) {
    auto made = environment::makeProcess(model.process, "");
    figures.unanswered += made ? 0 : 1;
    process = made ? std::move(*made) : nullptr;
  }
  simulation::SimulationOptions options;
  options.seed = number;
  options.hasSeed = true;
  options.threads = threads;
  options.limits.maximumModules = kMostModules;
  addRun(program, std::move(process), std::move(options), hash, figures);
}

int printRandomModels(std::uint32_t first, std::uint32_t count, unsigned threads, std::uint32_t block) {
  Figures figures;
  for (std::uint32_t begin = first; begin < first + count; begin += block) {
    core::Hasher hash;
    for (std::uint32_t number = begin; number < std::min(begin + block, first + count); ++number) {
      addRandomModel(number, threads, hash, figures);
    }
    std::printf("random %05u %016" PRIx64 "\n", begin, hash.value());
    std::fflush(stdout);
  }
  std::fprintf(stderr, "%u models: %u do not compile, %u without their environment, %u stopped\n", count,
               figures.failures, figures.unanswered, figures.stopped);
  return figures.failures == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

bool printGalleryModel(const std::string& folder, const std::string& name, unsigned threads) {
  DiskFiles files;
  Figures figures;
  std::string stem = folder;
  stem.append("/").append(name).append("/").append(name);
  const auto program = compiled(stem + ".l", files.read(stem + ".v") ? stem + ".v" : "", files, figures);
  if (!program) {
    std::fprintf(stderr, "%s: does not compile\n", name.c_str());
    return false;
  }
  simulation::SimulationOptions options;
  options.seed = 1;
  options.hasSeed = true;
  options.threads = threads;
  core::Hasher hash;
  addRun(program, environmentBeside(stem + ".l", files), std::move(options), hash, figures);
  std::printf("gallery %s %016" PRIx64 "\n", name.c_str(), hash.value());
  return figures.stopped == 0;
}

std::uint32_t numberOf(const char* text) {
  return static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10));
}

}  // namespace
}  // namespace espalier::test

int main(int argumentCount, char** arguments) {
  using namespace espalier::test;
  const std::string_view what = argumentCount > 3 ? arguments[1] : "";
  if ((what == "random" || what == "each") && argumentCount == 5) {
    return printRandomModels(numberOf(arguments[2]), numberOf(arguments[3]), numberOf(arguments[4]),
                             what == "each" ? 1 : kBlock);
  }
  if (what == "gallery") {
    bool isComplete = true;
    for (int i = 4; i < argumentCount; ++i) {
      isComplete = printGalleryModel(arguments[2], arguments[i], numberOf(arguments[3])) && isComplete;
    }
    return isComplete ? EXIT_SUCCESS : EXIT_FAILURE;
  }
  std::fprintf(stderr, "usage: espalier_bits random|each FIRST COUNT THREADS, or gallery FOLDER THREADS NAME...\n");
  return EXIT_FAILURE;
}

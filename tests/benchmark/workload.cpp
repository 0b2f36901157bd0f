#include "tests/benchmark/workload.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "engine/core/buffer.h"
#include "engine/language/compiler.h"
#include "environment/registry.h"
#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::benchmarking {
namespace {

using Clock = std::chrono::steady_clock;

// below this a second thread costs more than it copies
constexpr std::uint64_t kSmallestSharedCopy = std::uint64_t{1} << 18U;
// bytes that one call of memcpy copies
constexpr std::uint64_t kCopiedPiece = std::uint64_t{1} << 20U;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::uint64_t residentBytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t size = 0;
  std::uint64_t resident = 0;
  file >> size >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// In pieces, so that one thread and two copy in the same way: above a size that depends on the caches (some 180 MB
/// here) the C library's memcpy writes past them, which takes half as long again for memory that is touched first.
void copyPieces(std::uint8_t* target, const std::uint8_t* source, std::uint64_t bytes) {
  for (std::uint64_t done = 0; done < bytes; done += kCopiedPiece) {
    std::memcpy(target + done, source + done, std::min(kCopiedPiece, bytes - done));
  }
}

void copyShared(std::uint8_t* target, const std::uint8_t* source, std::uint64_t bytes, unsigned threads) {
  if (threads <= 1 || bytes < kSmallestSharedCopy) {
    copyPieces(target, source, bytes);
    return;
  }
  std::vector<std::jthread> helpers;
  const std::uint64_t part = bytes / threads;
  for (unsigned i = 1; i < threads; ++i) {
    const std::uint64_t begin = part * i;
    const std::uint64_t end = i + 1 == threads ? bytes : begin + part;
    helpers.emplace_back([=] { copyPieces(target + begin, source + begin, end - begin); });
  }
  copyPieces(target, source, part);
}

}  // namespace

std::string Workload::name() const {
  return model + (size.empty() ? "" : "/" + size) + "/" + steps;
}

std::shared_ptr<const language::Program> compileFile(const std::string& modelFile, const std::string& viewFile,
                                                     Defines defines) {
  test::DiskFiles files;
  language::CompileInput input;
  input.modelFile = modelFile;
  input.viewFile = viewFile;
  input.defines = std::move(defines);
  language::CompileResult result = language::compile(input, files);
  if (!result.program) {
    std::string text = modelFile + " does not compile";
    for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
      text += "\n" + core::formatDiagnostic(diagnostic);
    }
    throw std::runtime_error(text);
  }
  return result.program;
}

std::shared_ptr<const language::Program> compileWorkload(const Workload& workload) {
  Defines defines{{"N", workload.steps}};
  if (!workload.size.empty()) {
    defines.emplace_back("K", workload.size);
  }
  const std::string name = sourceFolder() + "/tests/benchmark/models/" + workload.model;
  const bool hasView = std::filesystem::exists(name + ".v");
  return compileFile(name + ".l", hasView ? name + ".v" : "", std::move(defines));
}

std::unique_ptr<turtle::EnvironmentProcess> makeProcess(const std::string& name, const std::string& configuration) {
  auto made = environment::makeProcess(name, configuration);
  if (!made) {
    throw std::runtime_error(made.error().front().message);
  }
  return std::move(*made);
}

void require(const std::optional<core::SimulationError>& error) {
  if (error) {
    throw std::runtime_error(error->message);
  }
}

DerivationRun runDerivation(const std::shared_ptr<const language::Program>& program, unsigned threads) {
  simulation::SimulationOptions options;
  options.threads = threads;
  const std::uint64_t residentBefore = residentBytes();
  simulation::Simulation simulation(program, {turtle::PlantPlacement{}}, nullptr, options);
  require(simulation.rewind());
  DerivationRun run;
  while (!simulation.isFinished()) {
    run.scannedModules += simulation.string().size();
    run.previousModules = simulation.string().size();
    run.previousParameters = simulation.string().parameterCount();
    // queries are not derivation
    require(simulation.answer());
    const auto start = Clock::now();
    require(simulation.step());
    run.seconds += secondsSince(start);
    run.stringBytes.push_back(simulation.string().bytes());
  }
  run.modules = simulation.string().size();
  run.parameters = simulation.string().parameterCount();
  const std::uint64_t residentAfter = residentBytes();
  run.residentBytes = residentAfter > residentBefore ? residentAfter - residentBefore : 0;
  return run;
}

double secondsToCopy(const std::vector<std::uint64_t>& stringBytes, unsigned threads) {
  if (stringBytes.empty()) {
    return 0.0;
  }
  core::Buffer<std::uint8_t> source;
  source.resize(*std::max_element(stringBytes.begin(), stringBytes.end()));
  std::fill_n(source.data(), source.size(), std::uint8_t{1});
  core::Buffer<std::uint8_t> target;
  core::Buffer<std::uint8_t> other;
  double seconds = 0.0;
  for (const std::uint64_t bytes : stringBytes) {
    const auto start = Clock::now();
    // as a step does, nothing of the old contents is kept
    target.clear();
    target.resize(bytes);
    copyShared(target.data(), source.data(), bytes, threads);
    target.swap(other);
    seconds += secondsSince(start);
  }
  return seconds;
}

double copiedBytesPerSecond(std::size_t bytes) {
  std::vector<char> from(bytes, 1);
  std::vector<char> to(bytes, 2);
  double best = 1e30;
  for (int k = 0; k < 6; ++k) {
    const auto start = Clock::now();
    std::memcpy(to.data(), from.data(), bytes);
    // the compiler shall not think that nobody reads it
    asm volatile("" : : "r"(to.data()) : "memory");
    best = std::min(best, std::chrono::duration<double>(Clock::now() - start).count());
    from.swap(to);
  }
  return 2.0 * static_cast<double>(bytes) / best;
}

}  // namespace espalier::benchmarking

#include "tests/benchmark/workload.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <stdexcept>

#include "engine/core/buffer.h"
#include "engine/language/compiler.h"
#include "tests/support/disk_files.h"

namespace espalier::benchmarking {

std::shared_ptr<const language::Program> compileFile(const std::string& modelFile, const std::string& viewFile,
                                                     std::vector<std::pair<std::string, std::string>> defines) {
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
  return compileFile(std::string(ESPALIER_SOURCE_DIR) + "/tests/benchmark/models/" + workload.model + ".l", "",
                     {{"N", workload.steps}});
}

void require(const std::optional<core::SimulationError>& error) {
  if (error) {
    throw std::runtime_error(error->message);
  }
}

double secondsToCopy(std::uint64_t bytes) {
  static std::map<std::uint64_t, double> measured;
  const auto known = measured.find(bytes);
  if (known != measured.end()) {
    return known->second;
  }
  core::Buffer<std::uint8_t> source;
  source.resize(bytes);
  std::fill_n(source.data(), bytes, std::uint8_t{1});
  double best = 1e30;
  for (int run = 0; run < 3; ++run) {
    core::Buffer<std::uint8_t> target;
    const auto start = std::chrono::steady_clock::now();
    target.append(source.view());
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  measured[bytes] = best;
  return best;
}

}  // namespace espalier::benchmarking

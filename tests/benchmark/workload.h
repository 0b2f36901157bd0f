#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/language/program.h"
#include "engine/simulation/simulation.h"

namespace espalier::benchmarking {

/// A model of models/ with its derivation length, as the figures of README.md have it.
struct Workload {
  std::string model;  // without folder and suffix
  std::string steps;  // value of the macro N
  unsigned threads = 1;
};

/// Compiles models/MODEL.l with N defined. Throws std::runtime_error with the diagnostics when it does not compile.
[[nodiscard]] std::shared_ptr<const language::Program> compileWorkload(const Workload& workload);

/// Compiles any model file. Throws as above.
[[nodiscard]] std::shared_ptr<const language::Program> compileFile(
    const std::string& modelFile, const std::string& viewFile,
    std::vector<std::pair<std::string, std::string>> defines);

/// Throws std::runtime_error when there is an error.
void require(const std::optional<core::SimulationError>& error);

/// Seconds that copying this many bytes to memory that has not been touched yet takes, the best of three: what a step
/// costs at least, since it writes its string. Measured once per size in a run.
[[nodiscard]] double secondsToCopy(std::uint64_t bytes);

}  // namespace espalier::benchmarking

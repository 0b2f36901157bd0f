#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/language/program.h"
#include "engine/simulation/simulation.h"

namespace espalier::benchmarking {

using Defines = std::vector<std::pair<std::string, std::string>>;

/// A model of models/ with the macros that say how much work it is: N, the derivation length, and for some K, the size.
struct Workload {
  std::string model;  // without folder and suffix
  std::string steps;  // value of the macro N
  std::string size;   // value of the macro K; empty: the model's own

  /// `model/N` or `model/K/N`, the part of a benchmark's name that says the workload.
  [[nodiscard]] std::string name() const;
};

/// Compiles models/MODEL.l with N and K defined. Throws std::runtime_error with the diagnostics when it does not
/// compile.
[[nodiscard]] std::shared_ptr<const language::Program> compileWorkload(const Workload& workload);

/// Compiles any model file. Throws as above.
[[nodiscard]] std::shared_ptr<const language::Program> compileFile(const std::string& modelFile,
                                                                   const std::string& viewFile, Defines defines);

/// Makes an environment process of the registry. Throws std::runtime_error.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makeProcess(const std::string& name,
                                                                      const std::string& configuration);

/// Throws std::runtime_error when there is an error.
void require(const std::optional<core::SimulationError>& error);

/// The time and the results of one run of a model from its axiom to its last step.
struct DerivationRun {
  double seconds = 0.0;                    // of all steps: `derivationMilliseconds` of `espalier derive --statistics`
  std::uint64_t scannedModules = 0;        // read by all steps
  std::uint64_t modules = 0;               // of the last string
  std::uint64_t parameters = 0;            // of the last string
  std::uint64_t previousModules = 0;       // of the string before the last
  std::uint64_t previousParameters = 0;    // of the string before the last
  std::uint64_t residentBytes = 0;         // that the process grew by: both strings and the needs of a step
  std::vector<std::uint64_t> stringBytes;  // of the string that each step wrote (stepCount)
};

/// Runs all steps in a new simulation: a run pays for its memory. Only the steps are timed, one by one, as the command
/// line does; not compiling, the axiom or giving the memory back.
[[nodiscard]] DerivationRun runDerivation(const std::shared_ptr<const language::Program>& program, unsigned threads);

/// Seconds that copying strings of these sizes takes: for each of them one memcpy from memory that has been written
/// before into the other of two buffers, which are used in turn and grow as a simulation's do, first touch included.
/// That is what a run costs at least, since each step writes its string. With several threads each copies its part.
[[nodiscard]] double secondsToCopy(const std::vector<std::uint64_t>& stringBytes, unsigned threads);

/// Bytes that a plain copy of so many bytes reads and writes in a second, from one block to another and back, as a
/// field that is relaxed goes to and fro; the best of several.
[[nodiscard]] double copiedBytesPerSecond(std::size_t bytes);

}  // namespace espalier::benchmarking

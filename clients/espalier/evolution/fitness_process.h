#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "clients/espalier/evolution/fitness.h"
#include "clients/espalier/evolution/genome.h"
#include "clients/espalier/result.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::command {

/// A plant that another program judges.
struct JudgedPlant {
  std::uint32_t generation = 0;
  std::uint64_t individual = 0;
  std::uint64_t modules = 0;
  const GenomeShape& shape;
  const Genome& genome;
  const PlantMeasures& measures;
  const turtle::Scene& scene;
  std::string string;  // of modules
};

/// Another program that gives plants their fitness. It reads a line of JSON for each plant on its standard input
/// (README of this folder) and answers with a line {"fitness": NUMBER} or {"error": TEXT}. `espalier.serve_fitness` of
/// the Python package is such a program.
class FitnessProcess {
 public:
  /// Starts `command` with the shell.
  [[nodiscard]] static Result<std::unique_ptr<FitnessProcess>> start(const std::string& command);
  ~FitnessProcess();

  /// The fitness of a plant. Waits at most `seconds` for the answer.
  [[nodiscard]] Result<double> judge(const JudgedPlant& plant, double seconds);

 private:
  struct Parts;
  explicit FitnessProcess(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace espalier::command

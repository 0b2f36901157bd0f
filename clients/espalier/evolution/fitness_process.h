#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <variant>

#include "clients/espalier/evolution/fitness.h"
#include "clients/espalier/evolution/genome.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::command {

/// A plant for somebody else to judge.
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

/// Another program that gives plants their fitness: for each a line of JSON on its standard input (README of this
/// folder), for each a line {"fitness": NUMBER} or {"error": TEXT} back. `espalier.serve_fitness` of the Python package
/// is its other side.
class FitnessProcess {
 public:
  /// Starts `command` by the shell, or returns an error sentence.
  [[nodiscard]] static std::variant<std::unique_ptr<FitnessProcess>, std::string> start(const std::string& command);
  ~FitnessProcess();

  /// The fitness of a plant, or an error sentence. `seconds`: how long to wait for it.
  [[nodiscard]] std::variant<double, std::string> judge(const JudgedPlant& plant, double seconds);

 private:
  struct Parts;
  explicit FitnessProcess(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace espalier::command

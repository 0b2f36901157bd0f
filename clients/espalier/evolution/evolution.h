#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/evolution/fitness.h"
#include "clients/espalier/evolution/genome.h"
#include "clients/espalier/result.h"

namespace espalier::command {

/// The settings of a genetic algorithm. A run depends on them, the model and its environment.
struct EvolutionSettings {
  std::string model;                  // hash of the Program with its environment and steps, to detect a change
  std::string fitness;                // as given on the command line
  std::uint64_t seed = 0;             // of the algorithm
  std::size_t populationCount = 40;   // individuals of a generation (at least 2)
  std::size_t eliteCount = 1;         // best individuals that stay unchanged in the next generation
  std::size_t tournamentSize = 3;     // individuals in a tournament; the best becomes a parent
  double mutationProbability = 0.15;  // of each gene
  double crossoverProbability = 0.7;  // else a child is a copy of one parent
  GenomeShape shape;
  std::vector<Successor> successors;  // the model's own, by predecessor

  bool operator==(const EvolutionSettings&) const = default;
};

/// A genome and the results of its plant.
struct Individual {
  Genome genome;
  bool isEvaluated = false;
  bool hasGrown = false;  // false: its model failed; its fitness is then below every other
  double fitness = 0.0;
  PlantMeasures measures;
  std::uint64_t modules = 0;
};

struct Generation {
  std::uint32_t number = 0;
  std::vector<Individual> individuals;
};

/// Whether the first is fitter. A plant that grew is fitter than a plant that failed.
[[nodiscard]] bool isFitter(const Individual& first, const Individual& second);
/// The index of the fittest; of equals the first.
[[nodiscard]] std::size_t fittest(const Generation& generation);

/// Generation 0. When productions vary, its first individual is the unchanged model.
[[nodiscard]] Generation firstGeneration(const EvolutionSettings& settings);
/// The generation after an evaluated one: the elite, then children of parents that won tournaments. A pure function of
/// its arguments. Goldberg 1989, "Genetic algorithms in search, optimization and machine learning".
[[nodiscard]] Generation nextGeneration(const EvolutionSettings& settings, const Generation& generation);

/// An evaluated generation with its settings, as a file. A later run continues from it.
[[nodiscard]] std::string writeEvolution(const EvolutionSettings& settings, const Generation& generation);
/// Reads the file back. A problem: the text is not such a file, or a run with other settings made it.
[[nodiscard]] Result<Generation> readEvolution(std::string_view text, const EvolutionSettings& settings);

}  // namespace espalier::command

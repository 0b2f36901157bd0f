#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "clients/espalier/evolution/fitness.h"
#include "clients/espalier/evolution/genome.h"

namespace espalier::command {

/// What a run of a genetic algorithm depends on, besides the model and its environment.
struct EvolutionSettings {
  std::string model;                  // hash of the Program and what grows it, to notice that it changed
  std::string fitness;                // as given on the command line
  std::uint64_t seed = 0;             // of the algorithm
  std::size_t populationCount = 40;   // individuals of a generation (at least 2)
  std::size_t eliteCount = 1;         // the best that pass on unchanged
  std::size_t tournamentSize = 3;     // of how many the best becomes a parent
  double mutationProbability = 0.15;  // of each gene
  double crossoverProbability = 0.7;  // else a child is a copy of one parent
  GenomeShape shape;
  std::vector<Successor> successors;  // the model's own, by predecessor

  bool operator==(const EvolutionSettings&) const = default;
};

/// A genome and what became of it.
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

/// Whether the first is fitter: plants that grew before those that failed.
[[nodiscard]] bool isFitter(const Individual& first, const Individual& second);
/// The index of the fittest; of equals the first.
[[nodiscard]] std::size_t fittest(const Generation& generation);

/// Generation 0. With productions its first individual is the model as it is.
[[nodiscard]] Generation firstGeneration(const EvolutionSettings& settings);
/// The generation after one that is evaluated: the elite, then children of parents that won tournaments. A pure
/// function of its arguments. Goldberg 1989, "Genetic algorithms in search, optimization and machine learning".
[[nodiscard]] Generation nextGeneration(const EvolutionSettings& settings, const Generation& generation);

/// An evaluated generation with its settings, as a file to go on from.
[[nodiscard]] std::string writeEvolution(const EvolutionSettings& settings, const Generation& generation);
/// Reads it back: the generation, or an error sentence when the text is none or was made with other settings.
[[nodiscard]] std::variant<Generation, std::string> readEvolution(std::string_view text,
                                                                  const EvolutionSettings& settings);

}  // namespace espalier::command

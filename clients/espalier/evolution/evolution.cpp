#include "clients/espalier/evolution/evolution.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

namespace espalier::command {
namespace {

const Individual& tournamentWinner(const EvolutionSettings& settings, const Generation& generation,
                                   GenomeRandom& random) {
  const Individual* best = nullptr;
  for (std::size_t i = 0; i < settings.tournamentSize; ++i) {
    const Individual& candidate = generation.individuals[random.index(generation.individuals.size())];
    if (best == nullptr || isFitter(candidate, *best)) {
      best = &candidate;
    }
  }
  return *best;
}

}  // namespace

bool isFitter(const Individual& first, const Individual& second) {
  if (first.hasGrown != second.hasGrown) {
    return first.hasGrown;
  }
  return first.fitness > second.fitness;
}

std::size_t fittest(const Generation& generation) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < generation.individuals.size(); ++i) {
    if (isFitter(generation.individuals[i], generation.individuals[best])) {
      best = i;
    }
  }
  return best;
}

Generation firstGeneration(const EvolutionSettings& settings) {
  Generation first;
  first.individuals.resize(settings.populationCount);
  for (std::size_t i = 0; i < settings.populationCount; ++i) {
    GenomeRandom random(settings.seed, 0, i);
    Genome& genome = first.individuals[i].genome;
    genome = randomGenome(settings.shape, settings.successors, random);
    if (i == 0) {
      genome.successors = settings.successors;
    }
  }
  return first;
}

Generation nextGeneration(const EvolutionSettings& settings, const Generation& generation) {
  std::vector<std::size_t> ranked(generation.individuals.size());
  std::iota(ranked.begin(), ranked.end(), std::size_t{0});
  std::stable_sort(ranked.begin(), ranked.end(), [&](std::size_t a, std::size_t b) {
    return isFitter(generation.individuals[a], generation.individuals[b]);
  });
  Generation next;
  next.number = generation.number + 1;
  for (std::size_t i = 0; i < settings.populationCount; ++i) {
    if (i < std::min(settings.eliteCount, ranked.size())) {
      next.individuals.push_back(generation.individuals[ranked[i]]);
      continue;
    }
    GenomeRandom random(settings.seed, next.number, i);
    const Individual& first = tournamentWinner(settings, generation, random);
    Individual child;
    child.genome =
        random.uniform() < settings.crossoverProbability
            ? crossed(settings.shape, first.genome, tournamentWinner(settings, generation, random).genome, random)
            : first.genome;
    mutate(settings.shape, child.genome, settings.mutationProbability, random);
    next.individuals.push_back(std::move(child));
  }
  return next;
}

}  // namespace espalier::command

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/random.h"

namespace espalier::command {

/// A variable number: a macro of the model with its range.
struct Gene {
  std::string name;
  double low = 0.0;
  double high = 1.0;

  bool operator==(const Gene&) const = default;
};

/// The common structure of all genomes of a run.
struct GenomeShape {
  std::vector<Gene> genes;                // numbers
  std::vector<std::string> predecessors;  // symbols whose successors vary; empty: productions do not vary
  std::vector<std::string> alphabet;      // modules of successors, besides `[` and `]`
  std::size_t longestSuccessor = 40;      // modules

  bool operator==(const GenomeShape&) const = default;
};

/// A successor as the texts of its modules; brackets are balanced.
using Successor = std::vector<std::string>;

/// The genes of one individual.
struct Genome {
  std::vector<double> values;         // by gene, each within its range
  std::vector<Successor> successors;  // by predecessor

  bool operator==(const Genome&) const = default;
};

/// The random draws of one individual. They depend only on the seed, the generation and the number of the individual.
class GenomeRandom {
 public:
  GenomeRandom(std::uint64_t seed, std::uint32_t generation, std::uint64_t individual)
      : random_(seed, 0), generation_(generation), individual_(individual) {}

  /// Uniform in [0, 1).
  double uniform() { return random_.uniform(core::DrawDomain::Selection, generation_, individual_, draw_++); }
  /// Uniform in 0 ... count - 1.
  std::size_t index(std::size_t count) { return static_cast<std::size_t>(uniform() * static_cast<double>(count)); }
  /// Normal with mean 0 and standard deviation 1 (Box & Muller 1958).
  double normal();

 private:
  core::CounterRandom random_;
  std::uint32_t generation_;
  std::uint64_t individual_;
  std::uint32_t draw_ = 0;
};

/// Genes drawn uniformly from their ranges; successors as given, each changed a few times.
[[nodiscard]] Genome randomGenome(const GenomeShape& shape, const std::vector<Successor>& successors,
                                  GenomeRandom& random);

/// A child of two: each number drawn from the interval of its parents, widened by half on both sides (BLX-0.5, Eshelman
/// & Schaffer 1993); each successor from either, in one case of three with a branch of it replaced by one of the
/// other's (Ochoa 1998).
[[nodiscard]] Genome crossed(const GenomeShape& shape, const Genome& first, const Genome& second, GenomeRandom& random);

/// Changes each number with `probability` by a normal step of a tenth of its range, and each successor with
/// `probability`: a module replaced, inserted, removed, moved into a branch of its own, or a branch replaced or removed
/// (Ochoa 1998). Ranges, balance and the longest successor hold.
void mutate(const GenomeShape& shape, Genome& genome, double probability, GenomeRandom& random);

/// Whether every `]` closes a `[` and none stays open.
[[nodiscard]] bool isBalanced(const Successor& successor);

}  // namespace espalier::command

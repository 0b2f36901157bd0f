#include "clients/espalier/evolution/genome.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>

#include "engine/core/elementary.h"

namespace espalier::command {
namespace {

using Place = Successor::difference_type;

// a branch [first, last) of a successor, brackets included
struct Branch {
  Place first = 0;
  Place last = 0;
};

std::vector<Branch> branchesOf(const Successor& successor) {
  std::vector<Branch> branches;
  std::vector<Place> open;
  for (Place i = 0; i < std::ssize(successor); ++i) {
    if (successor[static_cast<std::size_t>(i)] == "[") {
      open.push_back(i);
    } else if (successor[static_cast<std::size_t>(i)] == "]") {
      branches.push_back({open.back(), i + 1});
      open.pop_back();
    }
  }
  return branches;
}

// places of modules that are no brackets
std::vector<Place> modulesOf(const Successor& successor) {
  std::vector<Place> places;
  for (Place i = 0; i < std::ssize(successor); ++i) {
    const std::string& module = successor[static_cast<std::size_t>(i)];
    if (module != "[" && module != "]") {
      places.push_back(i);
    }
  }
  return places;
}

Successor randomBranch(const GenomeShape& shape, GenomeRandom& random) {
  Successor branch{"["};
  const std::size_t count = 1 + random.index(4);
  for (std::size_t i = 0; i < count; ++i) {
    branch.push_back(shape.alphabet[random.index(shape.alphabet.size())]);
  }
  branch.emplace_back("]");
  return branch;
}

void replace(Successor& successor, const Branch& branch, const Successor& by) {
  successor.erase(successor.begin() + branch.first, successor.begin() + branch.last);
  successor.insert(successor.begin() + branch.first, by.begin(), by.end());
}

void changeSuccessor(const GenomeShape& shape, Successor& successor, GenomeRandom& random) {
  const std::vector<Place> modules = modulesOf(successor);
  const std::vector<Branch> branches = branchesOf(successor);
  const std::string& module = shape.alphabet[random.index(shape.alphabet.size())];
  const auto somewhere = successor.begin() + static_cast<Place>(random.index(successor.size() + 1));
  const std::size_t change = random.index(6);
  if (change == 0 || modules.empty()) {
    successor.insert(somewhere, module);
  } else if (change == 1) {
    successor[static_cast<std::size_t>(modules[random.index(modules.size())])] = module;
  } else if (change == 2) {
    // a successor never becomes empty: the plant would end there
    if (modules.size() > 1) {
      successor.erase(successor.begin() + modules[random.index(modules.size())]);
    }
  } else if (change == 3) {
    const auto place = static_cast<std::size_t>(modules[random.index(modules.size())]);
    const Successor branch{"[", successor[place], "]"};
    replace(successor, {static_cast<Place>(place), static_cast<Place>(place) + 1}, branch);
  } else if (change == 4 || branches.empty()) {
    const Successor branch = randomBranch(shape, random);
    successor.insert(somewhere, branch.begin(), branch.end());
  } else {
    const Branch& branch = branches[random.index(branches.size())];
    const bool isAll = branch.first == 0 && branch.last == std::ssize(successor);
    replace(successor, branch, random.uniform() < 0.5 && !isAll ? Successor{} : randomBranch(shape, random));
  }
}

double within(const Gene& gene, double value) {
  return std::clamp(value, gene.low, gene.high);
}

}  // namespace

double GenomeRandom::normal() {
  const double radius = std::sqrt(-2.0 * core::log(1.0 - uniform()));
  return radius * core::cos(2.0 * std::numbers::pi * uniform());
}

bool isBalanced(const Successor& successor) {
  std::ptrdiff_t depth = 0;
  for (const std::string& module : successor) {
    depth += module == "[" ? 1 : module == "]" ? -1 : 0;
    if (depth < 0) {
      return false;
    }
  }
  return depth == 0;
}

Genome randomGenome(const GenomeShape& shape, const std::vector<Successor>& successors, GenomeRandom& random) {
  Genome genome;
  for (const Gene& gene : shape.genes) {
    genome.values.push_back(gene.low + (gene.high - gene.low) * random.uniform());
  }
  genome.successors = successors;
  for (Successor& successor : genome.successors) {
    const std::size_t changes = random.index(4);
    for (std::size_t i = 0; i < changes && successor.size() + 6 <= shape.longestSuccessor; ++i) {
      changeSuccessor(shape, successor, random);
    }
  }
  return genome;
}

Genome crossed(const GenomeShape& shape, const Genome& first, const Genome& second, GenomeRandom& random) {
  Genome child = first;
  for (std::size_t i = 0; i < shape.genes.size(); ++i) {
    const auto [low, high] = std::minmax(first.values[i], second.values[i]);
    const double margin = (high - low) / 2.0;
    child.values[i] = within(shape.genes[i], low - margin + (high - low + 2.0 * margin) * random.uniform());
  }
  for (std::size_t i = 0; i < shape.predecessors.size(); ++i) {
    const bool isFirst = random.uniform() < 0.5;
    const Successor& from = isFirst ? first.successors[i] : second.successors[i];
    const Successor& other = isFirst ? second.successors[i] : first.successors[i];
    child.successors[i] = from;
    const std::vector<Branch> own = branchesOf(from);
    const std::vector<Branch> others = branchesOf(other);
    if (own.empty() || others.empty() || random.uniform() >= 1.0 / 3.0) {
      continue;
    }
    const Branch& given = others[random.index(others.size())];
    replace(child.successors[i], own[random.index(own.size())],
            Successor(other.begin() + given.first, other.begin() + given.last));
    if (child.successors[i].size() > shape.longestSuccessor) {
      child.successors[i] = from;
    }
  }
  return child;
}

void mutate(const GenomeShape& shape, Genome& genome, double probability, GenomeRandom& random) {
  for (std::size_t i = 0; i < shape.genes.size(); ++i) {
    if (random.uniform() < probability) {
      const Gene& gene = shape.genes[i];
      genome.values[i] = within(gene, genome.values[i] + 0.1 * (gene.high - gene.low) * random.normal());
    }
  }
  for (Successor& successor : genome.successors) {
    if (random.uniform() < probability) {
      Successor changed = successor;
      changeSuccessor(shape, changed, random);
      if (changed.size() <= shape.longestSuccessor) {
        successor = std::move(changed);
      }
    }
  }
}

}  // namespace espalier::command

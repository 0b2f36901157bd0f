#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "environment/hydraulics/hydraulic_tree.h"

namespace espalier::environment {

/// The properties of roots alone, independent of the soil and the collar: the conductance of a plant (Krs) and the part
/// of its uptake that each segment takes from a soil whose total head is the same everywhere (SUF).
class UptakeFractions {
 public:
  /// Takes the trees of a step, the nodes of one plant together. A plant whose nodes are those of the call before keeps
  /// what is known. O(nodes).
  void update(std::vector<HydraulicTree::Node> nodes);

  /// length²/day; of a plant without nodes 0.
  [[nodiscard]] double conductanceOf(std::uint32_t plant) const {
    return plant < conductances_.size() ? conductances_[plant] : 0.0;
  }
  /// (nodes)
  [[nodiscard]] const std::vector<double>& fractions() const { return fractions_; }
  /// How many plants kept what was known in the last call of update().
  [[nodiscard]] std::size_t keptPlants() const { return keptPlants_; }

 private:
  /// The nodes of one plant.
  struct Range {
    std::size_t first = 0, end = 0;
  };
  [[nodiscard]] bool isKept(const std::vector<HydraulicTree::Node>& nodes, const Range& now, const Range& before) const;

  std::vector<HydraulicTree::Node> nodes_;
  std::vector<Range> ranges_;         // (plants)
  std::vector<double> conductances_;  // (plants)
  std::vector<double> fractions_;     // (nodes)
  std::size_t keptPlants_ = 0;
};

}  // namespace espalier::environment

#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/scan/block_runner.h"
#include "engine/derivation/scan/scan_context.h"
#include "engine/derivation/scan/sub_systems.h"

namespace espalier::derivation {

/// Expands modules by the homomorphism productions, for drawing. The string stays as it is; variables and random
/// streams may change.
class Homomorphism {
 public:
  /// All must outlive the object.
  Homomorphism(ScanContext& context, BlockRunner& blocks, SubSystems& calls);

  [[nodiscard]] bool hasProductions() const { return hasProductions_; }
  /// Prepares expand for the string of `state`. After ScanContext::attach.
  void begin(const PlantState& state);
  /// Does what Derivation::expand says.
  std::uint64_t expand(PlantState& state, std::uint32_t instance, std::uint64_t module, std::uint64_t parameterOffset,
                       ModuleString& image);

 private:
  void findParents(const ModuleString& string);
  void enterCalls(std::uint32_t instance);

  ScanContext* context_;
  BlockRunner* blocks_;
  SubSystems* calls_;
  bool hasProductions_ = false;         // in any L-system of the Program
  bool hasContexts_ = false;            // one of the productions looks at neighbours
  std::vector<std::uint32_t> parents_;  // by instance: the call around it
  std::vector<std::uint32_t> chain_;    // of calls, working memory
};

}  // namespace espalier::derivation

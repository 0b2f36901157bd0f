#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// Runs the blocks of an L-system: Start, StartEach, EndEach, End, and the expressions of the axiom.
class BlockRunner {
 public:
  /// The number is part of the key of a block's draws.
  enum class Block : std::uint8_t { Start = 0, Axiom = 1, StartEach = 2, EndEach = 3, End = 4 };

  /// `context` must outlive the object.
  explicit BlockRunner(ScanContext& context);

  /// Runs the code of a block, with the variables that the evaluator has entered. `instance`: position of the call of a
  /// sub-L-system (0: the main L-system).
  void run(language::CodeRange code, Block block, std::uint32_t instance);
  /// Appends the axiom of the main L-system.
  void appendAxiom(ModuleString& string);

 private:
  ScanContext* context_;
  std::vector<double> frame_;  // formal parameters; blocks have none, but code needs a frame (Program::maximumSlots)
};

}  // namespace espalier::derivation

#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/derivation.h"
#include "engine/language/program.h"
#include "engine/turtle/environment_process.h"
#include "engine/turtle/scene.h"
#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

/// Where a plant stands: the turtle starts here.
struct PlantPlacement {
  core::Vec3 position;
  core::Frame frame;
};

/// What one interpretation produces. Null members are not produced.
struct InterpretationOutput {
  Scene* scene = nullptr;
  QueryBatch* queries = nullptr;              // communication modules are appended
  EnvironmentNeeds needs;                     // of whoever reads `queries`
  std::vector<TurtleRecord>* records = nullptr;
  std::vector<std::uint64_t>* queryParameterOffsets = nullptr;  // per appended query: where its parameters are in the string
};

/// Interprets the string of one plant from left to right, with homomorphism, filling ?P ?H ?L ?U ?Q (and ?F) in place.
/// In an environment pass (`queries` given) of the compatible modes, width and colour symbols are not executed
/// (ENVIRONMENTS §5.3). Throws core::SimulationFailure.
class Interpreter {
 public:
  /// `program` must outlive the object.
  explicit Interpreter(const language::Program& program);

  void interpret(derivation::Derivation& derivation, derivation::PlantState& state, std::uint32_t plant,
                 const PlantPlacement& placement, const InterpretationOutput& output);

 private:
  const language::Program* program_;
  std::vector<std::uint8_t> commandOf_;  // turtle command by module type (moduleTypeCount)
};

}  // namespace espalier::turtle

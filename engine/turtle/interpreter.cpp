#include "engine/turtle/interpreter.h"

#include "engine/turtle/interpretation.h"
#include "engine/turtle/turtle_command.h"

namespace espalier::turtle {

Interpreter::Interpreter(const language::Program& program) : program_(&program) {
  const std::size_t typeCount = program.moduleTypeCount();
  commandOf_.resize(typeCount);
  mayExpand_.resize(typeCount, false);
  for (std::size_t type = 0; type < typeCount; ++type) {
    const language::ModuleType& moduleType = program.types[type];
    commandOf_[type] =
        static_cast<std::uint8_t>(commandOf(program.symbols[moduleType.symbol].character(), moduleType.arity));
  }
  for (const language::LSystem& system : program.systems) {
    for (const language::Production& production : system.homomorphism.productions) {
      mayExpand_[production.predecessor.front().type] = true;
    }
  }
}

void Interpreter::interpret(derivation::Derivation& derivation, derivation::PlantState& state, std::uint32_t plant,
                            const PlantPlacement& placement, const InterpretationOutput& output) {
  Interpretation interpretation({*program_, commandOf_, mayExpand_, reported_}, derivation, state, plant, placement,
                                output);
  interpretation.run();
}

}  // namespace espalier::turtle

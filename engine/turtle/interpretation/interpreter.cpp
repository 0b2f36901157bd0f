#include "engine/turtle/interpretation/interpreter.h"

#include "engine/turtle/interpretation/interpretation.h"
#include "engine/turtle/interpretation/parted_interpretation.h"
#include "engine/turtle/interpretation/query_stretches.h"
#include "engine/turtle/interpretation/record_chain_builder.h"

namespace espalier::turtle {

Interpreter::Interpreter(const language::Program& program)
    : program_(&program),
      tables_(program),
      mayTakeOver_(!tables_.hasImages && isRepeatable(program)),
      parted_(std::make_unique<PartedInterpretation>()) {}

Interpreter::~Interpreter() = default;

void Interpreter::interpret(derivation::Derivation& derivation, derivation::PlantState& state, std::uint32_t plant,
                            const PlantPlacement& placement, const InterpretationOutput& output) {
  const Interpretation::Subject subject{*program_, tables_, reported_, derivation, state, plant, placement};
  if (!parted_->run(subject, output)) {
    Interpretation(subject, output).run();
  }
}

void Interpreter::takeOver(derivation::Derivation& derivation, derivation::PlantState& state, std::uint32_t plant,
                           const PlantPlacement& placement, const InterpretationOutput& output,
                           const derivation::StepChanges& changes, QueryStretches& known) {
  known.run({*program_, tables_, reported_, derivation, state, plant, placement}, output, changes);
}

void Interpreter::appendRecords(derivation::Derivation& derivation, derivation::PlantState& state, std::uint32_t plant,
                                const PlantPlacement& placement, const RecordChain* base,
                                const derivation::StepChanges& changes,
                                const std::function<void(std::span<TurtleRecord>)>& rename, RecordChain& chain) {
  const Interpretation::Subject subject{*program_, tables_, reported_, derivation, state, plant, placement};
  RecordChainBuilder(subject, base, changes, rename, chain).appendPlant();
}

}  // namespace espalier::turtle

#include "engine/derivation/scan/scan_context.h"

#include <algorithm>
#include <utility>

namespace espalier::derivation {
namespace {

Evaluator::Options evaluatorOptions(const DerivationOptions& options) {
  return {options.plant, options.limits, options.cancelled, options.messages, options.canWriteFiles};
}

}  // namespace

ScanContext::ScanContext(const language::Program& compiled, const std::vector<SystemTables>& systemTables,
                         DerivationOptions given)
    : program(compiled),
      options(std::move(given)),
      tables(systemTables),
      random(program.compatibility, options.plant),
      evaluator(program, random, evaluatorOptions(options)),
      rewriter(program, evaluator, random, options.limits),
      cuts(program),
      index(program) {}

void ScanContext::attach(PlantState& state, std::uint64_t number, std::uint64_t failingStep) {
  step = number;
  plant = &state;
  evaluator.attach(state);
  evaluator.setStep(number, failingStep);
  evaluator.clearModule();
  evaluator.enter(state.instances.front());
  random.attach(state.random);
}

void ScanContext::read(const ModuleString& string, const StringIndex& links, const ModuleString* produced,
                       ProducedPieces* pieces) {
  old = &string;
  shortcuts.clear();
  rewriter.setStrings({string.types().data(), string.parameters().data(), string.size(), string.parameterCount(),
                       &links, true, &shortcuts},
                      produced, pieces);
}

void ScanContext::buildIndex(const ModuleString& string) {
  isOutputIndexed = false;
  index.clear();
  index.extend(string);
}

void ScanContext::noteEqualEnds(const ScanPlace& begin, const ScanPlace& end, std::uint64_t modules,
                                std::uint64_t parameters) {
  if (changes != nullptr) {
    changes->keepEqualEnds({old->types().subspan(begin.module, end.module - begin.module),
                            old->parameters().subspan(begin.offset, end.offset - begin.offset), begin.module},
                           {std::as_const(output).types().subspan(modules),
                            std::as_const(output).parameters().subspan(parameters), modules},
                           program.arity);
  }
}

bool ScanContext::isCancelled() const {
  return options.cancelled != nullptr && options.cancelled->load(std::memory_order_relaxed);
}

bool ScanContext::isWithinLimits(std::uint64_t moduleCount, std::uint64_t parameterCount) const {
  return moduleCount <= options.limits.maximumModules &&
         moduleCount * 2 + parameterCount * 8 <= options.limits.maximumStringBytes;
}

void ScanContext::reserveOutput(std::uint64_t moduleCount, std::uint64_t parameterCount) {
  core::Buffer<core::ModuleTypeId>& types = output.typeBuffer();
  core::Buffer<double>& parameters = output.parameterBuffer();
  if (moduleCount > types.capacity()) {
    types.reserve(std::max<std::uint64_t>(moduleCount, types.capacity() + types.capacity() / 2));
  }
  if (parameterCount > parameters.capacity()) {
    parameters.reserve(std::max<std::uint64_t>(parameterCount, parameters.capacity() + parameters.capacity() / 2));
  }
}

}  // namespace espalier::derivation

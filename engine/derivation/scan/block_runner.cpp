#include "engine/derivation/scan/block_runner.h"

namespace espalier::derivation {

BlockRunner::BlockRunner(ScanContext& context)
    : context_(&context), frame_(context.program.maximumSlots + std::size_t{1}, 0.0) {}

void BlockRunner::run(language::CodeRange code, Block block, std::uint32_t instance) {
  if (code.empty()) {
    return;
  }
  context_->evaluator.clearModule();
  context_->random.key(core::DrawDomain::Blocks, context_->step,
                       static_cast<std::uint64_t>(block) + std::uint64_t{8} * instance);
  context_->evaluator.run(code, frame_.data());
}

void BlockRunner::appendAxiom(ModuleString& string) {
  const language::LSystem& system = context_->program.systems.front();
  context_->random.key(core::DrawDomain::Blocks, context_->step, static_cast<std::uint64_t>(Block::Axiom));
  std::vector<double> parameters;
  for (const language::SuccessorModule& module : system.axiom) {
    parameters.clear();
    for (std::size_t i = 0; i < context_->program.arity[module.type]; ++i) {
      const language::Expression& expression = system.axiomExpressions[module.firstExpression + i];
      const double value = context_->evaluator.value(expression, frame_.data());
      parameters.push_back(context_->rewriter.stored(value, expression, i, module.type));
    }
    string.append(module.type, parameters);
  }
}

}  // namespace espalier::derivation

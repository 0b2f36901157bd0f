#include "engine/derivation/scan/homomorphism.h"

#include <utility>

namespace espalier::derivation {
namespace {

bool hasOwnStream(const language::LSystem& system) {
  return system.homomorphismSeed && *system.homomorphismSeed >= 0.0;
}

/// Random numbers come from the homomorphism's own stream as long as this object lives, also when the model fails.
class PrivateStream {
 public:
  PrivateStream(RandomSource& random, bool isUsed) : random_(&random) { random_->usePrivateStream(isUsed); }
  ~PrivateStream() { random_->usePrivateStream(false); }
  PrivateStream(const PrivateStream&) = delete;
  PrivateStream& operator=(const PrivateStream&) = delete;

 private:
  RandomSource* random_;
};

}  // namespace

Homomorphism::Homomorphism(ScanContext& context, BlockRunner& blocks, SubSystems& calls)
    : context_(&context), blocks_(&blocks), calls_(&calls) {
  for (const language::LSystem& system : context.program.systems) {
    hasProductions_ = hasProductions_ || !system.homomorphism.productions.empty();
    hasContexts_ = hasContexts_ || looksAround(system.homomorphism);
  }
}

void Homomorphism::begin(const PlantState& state) {
  context_->shortcuts.clear();
  if (!hasProductions_) {
    return;
  }
  if (hasContexts_) {
    context_->buildIndex(state.string);
  }
  if (context_->program.hasSubSystems) {
    findParents(state.string);
  }
  for (const language::LSystem& system : context_->program.systems) {
    if (hasOwnStream(system)) {
      context_->random.startPrivateStream(*system.homomorphismSeed);
      break;
    }
  }
}

void Homomorphism::findParents(const ModuleString& string) {
  parents_.assign(1, 0);
  chain_.assign(1, 0);
  for (const core::ModuleTypeId type : string.types()) {
    if (calls_->isCall(type)) {
      parents_.push_back(chain_.back());
      chain_.push_back(static_cast<std::uint32_t>(parents_.size() - 1));
    } else if (type == context_->program.subSystemEnd && chain_.size() > 1) {
      chain_.pop_back();
    }
  }
}

void Homomorphism::enterCalls(std::uint32_t instance) {
  if (instance == 0) {
    return;
  }
  chain_.clear();
  for (std::uint32_t i = instance; i != 0; i = parents_[i]) {
    chain_.push_back(i);
  }
  CallStack& stack = calls_->stack();
  for (auto i = chain_.rbegin(); i != chain_.rend(); ++i) {
    stack.push(*i);
  }
  if (!std::exchange(stack.state().hasStarted, true)) {
    blocks_->run(context_->program.systems[stack.state().system].start, BlockRunner::Block::Start, instance);
  }
}

std::uint64_t Homomorphism::expand(PlantState& state, std::uint32_t instance, std::uint64_t module,
                                   std::uint64_t parameterOffset, ModuleString& image) {
  ScanContext& context = *context_;
  const ModuleString& string = state.string;
  const core::ModuleTypeId type = string.types()[module];
  const language::LSystem& system = context.program.systems[state.instances[instance].system];
  const language::ProductionList& list = system.homomorphism;
  if (list.index.empty() || list.maximumDepth == 0 || list.index.candidates(type).empty()) {
    return 0;
  }
  enterCalls(instance);

  // contexts follow the rules of the main L-system
  context.rewriter.setStrings({string.types().data(), string.parameters().data(), string.size(),
                               string.parameterCount(), &context.index, true, &context.shortcuts},
                              nullptr);
  const ContextRules& rules = context.tables.front().rules;
  const PredecessorPlace place{string.types().data(), string.parameters().data(), string.size(), module,
                               parameterOffset};
  Surroundings surroundings{module, parameterOffset, 0, 0, true};
  context.evaluator.setModule(module, type);
  context.random.key(core::DrawDomain::Interpretation, hasOwnStream(system) ? 0 : context.step, module);
  std::uint64_t consumed = 0;
  if (const language::Production* production = context.rewriter.chooseFirst(list, rules, place, surroundings)) {
    consumed = production->predecessor.size();
    surroundings.right = module + consumed;
    surroundings.rightOffset = parameterOffset + context.rewriter.parameterCount(*production);
    surroundings.isBehindPredecessor = false;
    const PrivateStream stream(context.random, hasOwnStream(system));
    context.rewriter.applyNested(*production, list, rules, surroundings, 1, true, core::DrawDomain::Interpretation,
                                 context.step, module, image);
  }
  while (calls_->stack().depth() > 1) {
    calls_->stack().pop();
  }
  return consumed;
}

}  // namespace espalier::derivation

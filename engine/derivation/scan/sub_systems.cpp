#include "engine/derivation/scan/sub_systems.h"

#include <cmath>
#include <string>
#include <utility>

#include "engine/core/number_text.h"

namespace espalier::derivation {

SubSystems::SubSystems(ScanContext& context, BlockRunner& blocks)
    : context_(&context), blocks_(&blocks), stack_(context.program, context.evaluator) {
  const language::Program& program = context.program;
  if (!program.hasSubSystems) {
    return;
  }
  isCall_.resize(program.moduleTypeCount(), 0);
  std::vector<std::uint8_t> isBarrier(program.moduleTypeCount(), 0);
  for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
    const auto type = static_cast<core::ModuleTypeId>(i);
    isCall_[type] = derivation::isCall(program, type) ? 1 : 0;
    isBarrier[type] = isCall_[type] != 0 || type == program.subSystemEnd ? 1 : 0;
  }
  context.rewriter.setBarriers(std::move(isBarrier));
}

void SubSystems::begin() {
  stack_.reset(context_->plant->instances);
}

std::uint32_t SubSystems::systemOfCall(double id) const {
  const std::vector<language::LSystem>& systems = context_->program.systems;
  for (std::uint32_t i = 0; i < systems.size(); ++i) {
    if (static_cast<double>(systems[i].label) == std::trunc(id)) {
      return i;
    }
  }
  std::string labels;
  for (const language::LSystem& system : systems) {
    labels += (labels.empty() ? "" : ", ") + std::to_string(system.label);
  }
  std::string number;
  core::appendNumber(number, id, core::NumberStyle::Shortest);
  context_->evaluator.failHere(
      core::SimulationErrorCode::Model,
      "?(" + number + ") calls an L-system that does not exist. Labels in this model: " + labels);
}

void SubSystems::addInstances(const ModuleString& string, std::vector<InstanceState>& instances) const {
  if (!context_->program.hasSubSystems) {
    return;
  }
  std::size_t offset = 0;
  for (const core::ModuleTypeId type : string.types()) {
    if (isCall(type)) {
      instances.push_back(makeInstance(context_->program, systemOfCall(string.parameters()[offset])));
    }
    offset += context_->program.arity[type];
  }
}

void SubSystems::enter(std::uint32_t instance) {
  stack_.push(instance);
  const language::LSystem& system = activeSystem();
  if (!std::exchange(stack_.state().hasStarted, true)) {
    blocks_->run(system.start, BlockRunner::Block::Start, instance);
  }
  blocks_->run(system.startEach, BlockRunner::Block::StartEach, instance);
}

void SubSystems::leave() {
  blocks_->run(activeSystem().endEach, BlockRunner::Block::EndEach, stack_.instance());
  stack_.pop();
}

void SubSystems::end() {
  if (stack_.state().hasStarted) {
    blocks_->run(activeSystem().end, BlockRunner::Block::End, stack_.instance());
  }
}

void SubSystems::endAll(const ModuleString& string) {
  if (!context_->program.hasSubSystems) {
    return;
  }
  std::uint32_t nextCall = 1;
  for (const core::ModuleTypeId type : string.types()) {
    if (isCall(type)) {
      stack_.push(nextCall++);
    } else if (type == context_->program.subSystemEnd && stack_.depth() > 1) {
      end();
      stack_.pop();
    }
  }
  // calls that the string does not close
  while (stack_.depth() > 1) {
    end();
    stack_.pop();
  }
}

}  // namespace espalier::derivation

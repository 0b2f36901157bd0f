#include "engine/derivation/expressions/call_stack.h"

#include <algorithm>
#include <string>

namespace espalier::derivation {

CallStack::CallStack(const language::Program& program, Evaluator& evaluator)
    : program_(&program), evaluator_(&evaluator), hasWarned_(program.systems.size(), 0) {}

void CallStack::reset(std::vector<InstanceState>& instances) {
  instances_ = &instances;
  frames_.clear();
  bindings_.clear();
  frames_.push_back({0, 0});
  evaluator_->enter(instances.front());
}

void CallStack::push(std::uint32_t instance, core::SourceRange range) {
  InstanceState& inner = (*instances_)[instance];
  const language::LSystem& system = program_->systems[inner.system];
  if (frames_.size() > kMaximumDepth) {
    evaluator_->failHere(core::SimulationErrorCode::LimitExceeded,
                         "calls of sub-L-systems are nested more than " + std::to_string(kMaximumDepth) + " deep",
                         range);
  }
  const bool isActive = std::any_of(frames_.begin(), frames_.end(), [&](const Frame& frame) {
    return (*instances_)[frame.instance].system == inner.system;
  });
  if (isActive) {
    evaluator_->failHere(core::SimulationErrorCode::Model,
                         "L-system " + system.name + " is called inside itself, which the language forbids", range);
  }

  const std::size_t firstBinding = bindings_.size();
  for (const std::uint32_t slot : system.externals) {
    const std::string& name = system.variables[slot];
    bool isBound = false;
    for (std::size_t i = frames_.size(); i-- > 0 && !isBound;) {
      const std::uint32_t outerInstance = frames_[i].instance;
      const std::vector<std::string>& names = program_->systems[(*instances_)[outerInstance].system].variables;
      const auto found = std::find(names.begin(), names.end(), name);
      if (found != names.end()) {
        const auto outerSlot = static_cast<std::uint32_t>(found - names.begin());
        bindings_.push_back({slot, outerInstance, outerSlot});
        inner.variables[slot] = (*instances_)[outerInstance].variables[outerSlot];
        isBound = true;
      }
    }
    if (!isBound && hasWarned_[inner.system] == 0) {
      hasWarned_[inner.system] = 1;
      evaluator_->warn(
          "no caller of L-system " + system.name + " has a variable '" + name + "'; the external variable is its own",
          range);
    }
  }
  frames_.push_back({instance, firstBinding});
  evaluator_->enter(inner);
}

void CallStack::pop() {
  const Frame frame = frames_.back();
  const InstanceState& inner = (*instances_)[frame.instance];
  for (std::size_t i = frame.firstBinding; i < bindings_.size(); ++i) {
    const Binding& binding = bindings_[i];
    (*instances_)[binding.outerInstance].variables[binding.outerSlot] = inner.variables[binding.slot];
  }
  bindings_.resize(frame.firstBinding);
  frames_.pop_back();
  evaluator_->enter(state());
}

}  // namespace espalier::derivation

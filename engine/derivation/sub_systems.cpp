#include <cmath>
#include <string>

#include "engine/core/check.h"
#include "engine/core/number_text.h"
#include "engine/derivation/implementation.h"

namespace espalier::derivation {

std::uint32_t Derivation::Implementation::systemOfCall(double id) const {
  for (std::uint32_t i = 0; i < program_->systems.size(); ++i) {
    if (static_cast<double>(program_->systems[i].label) == std::trunc(id)) {
      return i;
    }
  }
  std::string labels;
  for (const language::LSystem& system : program_->systems) {
    labels += (labels.empty() ? "" : ", ") + std::to_string(system.label);
  }
  std::string number;
  core::appendNumber(number, id, core::NumberStyle::Shortest);
  evaluator_.failHere(core::SimulationErrorCode::Model,
                      "?(" + number + ") calls an L-system that does not exist. Labels in this model: " + labels);
}

void Derivation::Implementation::addCallsOf(const ModuleString& string, std::vector<InstanceState>& instances) {
  if (!program_->hasSubSystems) {
    return;
  }
  std::size_t offset = 0;
  for (const core::ModuleTypeId type : string.types()) {
    if (isCall_[type] != 0) {
      instances.push_back(makeInstance(*program_, systemOfCall(string.parameters()[offset])));
    }
    offset += program_->arity[type];
  }
}

void Derivation::Implementation::addCalls(std::uint64_t firstModule, std::uint64_t firstParameter) {
  const std::span<const core::ModuleTypeId> types = working_.types();
  std::uint64_t offset = firstParameter;
  for (std::uint64_t i = firstModule; i < types.size(); ++i) {
    if (isCall_[types[i]] != 0) {
      callOrigins_.push_back({true, systemOfCall(working_.parameters()[offset])});
    }
    offset += program_->arity[types[i]];
  }
}

void Derivation::Implementation::enterCall(PlantState& state, std::uint32_t instance) {
  calls_.push(instance);
  const language::LSystem& system = program_->systems[state.instances[instance].system];
  if (!state.instances[instance].hasStarted) {
    state.instances[instance].hasStarted = true;
    runBlock(system.start, Block::Start, instance);
  }
  runBlock(system.startEach, Block::StartEach, instance);
}

void Derivation::Implementation::leaveCall(PlantState& state) {
  const std::uint32_t instance = calls_.instance();
  runBlock(program_->systems[state.instances[instance].system].endEach, Block::EndEach, instance);
  calls_.pop();
}

void Derivation::Implementation::endCall(PlantState& state, std::uint32_t instance) {
  if (state.instances[instance].hasStarted) {
    runBlock(program_->systems[state.instances[instance].system].end, Block::End, instance);
  }
}

void Derivation::Implementation::scanWithCalls(PlantState& state) {
  const ModuleString& old = state.string;
  const std::span<const core::ModuleTypeId> types = old.types();
  callOrigins_.clear();
  keptCallOrigins_.clear();
  std::uint32_t nextCall = 1;
  std::uint64_t module = 0;
  std::uint64_t offset = 0;
  while (module < types.size()) {
    if ((module & 0xFFFU) == 0) {
      evaluator_.pollCancelled();
    }
    const core::ModuleTypeId type = types[module];
    // a `$` belongs to the caller
    if (type == program_->subSystemEnd && calls_.depth() > 1) {
      leaveCall(state);
    }
    const SystemTables& tables = tables_[state.instances[calls_.instance()].system];
    const double draw = random_.isSequential() && tables.system->isStochastic ? random_.selection(step_, module) : 0.0;
    const std::uint64_t firstModule = working_.size();
    const std::uint64_t firstParameter = working_.parameterCount();
    const Outcome outcome = rewriteModule(tables, old, module, offset, draw, working_);
    const bool isOldCall = isCall_[type] != 0;
    const std::uint32_t instance = nextCall;
    nextCall += isOldCall ? 1 : 0;

    switch (outcome.fate) {
      case Fate::Rewritten:
        addCalls(firstModule, firstParameter);
        // a call whose module was rewritten is gone
        if (isOldCall) {
          calls_.push(instance);
          endCall(state, instance);
          calls_.pop();
        }
        break;
      case Fate::Copied:
        if (isOldCall) {
          ESPALIER_CHECK(instance < state.instances.size());
          callOrigins_.push_back({false, instance});
          enterCall(state, instance);
        }
        break;
      case Fate::Cut: {
        const StringPart part = cutWithCalls(state, module, offset, nextCall);
        module = part.endModule;
        offset = part.endParameter;
        break;
      }
    }
    if (outcome.fate != Fate::Cut) {
      module += outcome.modules;
      offset += outcome.parameters;
    }
    rewriter_.checkSize(working_.size(), working_.parameterCount());
  }
  while (calls_.depth() > 1) {
    leaveCall(state);
  }

  // the instances of the new string's calls; those in parts that `%(p)` cut go to its end with them
  callOrigins_.insert(callOrigins_.end(), keptCallOrigins_.begin(), keptCallOrigins_.end());
  std::vector<InstanceState> instances;
  instances.reserve(callOrigins_.size() + 1);
  instances.push_back(std::move(state.instances.front()));
  for (const CallOrigin& origin : callOrigins_) {
    instances.push_back(origin.isFresh ? makeInstance(*program_, origin.index)
                                       : std::move(state.instances[origin.index]));
  }
  state.instances = std::move(instances);
  calls_.reset(state.instances);
}

Derivation::Implementation::StringPart Derivation::Implementation::cutWithCalls(PlantState& state, std::uint64_t module,
                                                                                std::uint64_t offset,
                                                                                std::uint32_t& nextCall) {
  // as cutPart, but a `$` of the call around ends the part as well, and calls inside it are removed, unless `%(p)`
  // keeps the part
  const bool isKept = state.string.types()[module] == cutWithTurtle_;
  const std::span<const core::ModuleTypeId> types = state.string.types();
  StringPart part{module + 1, module + 1, offset + program_->arity[types[module]], 0};
  part.endParameter = part.firstParameter;
  const std::size_t outerDepth = calls_.depth();
  std::uint64_t branchDepth = 0;
  const auto removeCall = [&] {
    if (!isKept) {
      endCall(state, calls_.instance());
    }
    calls_.pop();
  };
  for (; part.endModule < types.size(); ++part.endModule) {
    const core::ModuleTypeId type = types[part.endModule];
    if (type == program_->openBranch) {
      ++branchDepth;
    } else if (type == program_->closeBranch) {
      if (branchDepth == 0) {
        break;
      }
      --branchDepth;
    } else if (isCall_[type] != 0) {
      if (isKept) {
        keptCallOrigins_.push_back({false, nextCall});
      }
      calls_.push(nextCall++);
    } else if (type == program_->subSystemEnd) {
      if (calls_.depth() > outerDepth) {
        removeCall();
      } else if (outerDepth > 1) {
        break;
      }
    }
    part.endParameter += program_->arity[type];
  }
  while (calls_.depth() > outerDepth) {
    removeCall();
  }
  keepCutPart(state.string, part, offset);
  return part;
}

void Derivation::Implementation::endAllCalls(PlantState& state) {
  if (!program_->hasSubSystems) {
    return;
  }
  // End of every call in the new string, inner ones first, with the variables of its callers
  std::uint32_t nextCall = 1;
  const auto end = [&] {
    endCall(state, calls_.instance());
    calls_.pop();
  };
  for (const core::ModuleTypeId type : working_.types()) {
    if (isCall_[type] != 0) {
      calls_.push(nextCall++);
    } else if (type == program_->subSystemEnd && calls_.depth() > 1) {
      end();
    }
  }
  while (calls_.depth() > 1) {
    end();
  }
}

}  // namespace espalier::derivation

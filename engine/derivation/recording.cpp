#include <algorithm>

#include "engine/derivation/implementation.h"

namespace espalier::derivation {

void Derivation::Implementation::deriveRecorded(PlantState& state, ModuleRecord& record) {
  // the caller's record must be let go of even when the model fails
  struct Recording {
    ModuleRecord*& slot;
    Rewriter& rewriter;
    ~Recording() {
      slot = nullptr;
      rewriter.setRecord(nullptr);
    }
  };
  record_ = &record;
  const Recording recording{record_, rewriter_};
  derive(state);
}

void Derivation::Implementation::scanRecorded(const PlantState& state) {
  const SystemTables& tables = tables_.front();
  const ModuleString& old = state.string;
  const bool drawsEachPosition = random_.isSequential() && tables.system->isStochastic;
  std::uint64_t offset = 0;
  for (std::uint64_t module = 0; module < old.size();) {
    if ((module & 0xFFFFU) == 0) {
      evaluator_.pollCancelled();
    }
    const double draw = drawsEachPosition ? random_.selection(step_, module) : 0.0;
    const Outcome outcome = rewriteModule(tables, old, module, offset, draw, working_);
    if (outcome.fate == Fate::Cut) {
      const StringPart part = cutPart(old, module, offset);
      keepCutPart(old, part, offset);
      module = part.endModule;
      offset = part.endParameter;
    } else {
      module += outcome.modules;
      offset += outcome.parameters;
    }
    rewriter_.checkSize(working_.size(), working_.parameterCount());
  }
}

Derivation::Implementation::Outcome Derivation::Implementation::rewriteRecorded(const SystemTables& tables,
                                                                                const ModuleString& old,
                                                                                std::uint64_t module,
                                                                                std::uint64_t offset, double draw,
                                                                                ModuleString& output) {
  // only a predecessor of several modules reaches from an earlier module to the one asked for; from right to left none
  // does
  std::size_t longest = 1;
  const bool isBackwards = tables_.front().isProducedBackwards && !program_->hasSubSystems;
  for (const language::ProductionList* list : {&tables.system->productions, &tables.system->decomposition}) {
    for (const language::Production& production : list->productions) {
      longest = isBackwards ? 1 : std::max(longest, production.predecessor.size());
    }
  }
  if (module > record_->module || record_->module - module >= longest) {
    return rewrite(tables, old, module, offset, draw, output);
  }

  ModuleRecord attempt;
  attempt.module = record_->module;
  attempt.first = module;
  attempt.system = tables.system;
  attempt.fate = module == attempt.module ? ModuleRecord::Fate::Unfinished : ModuleRecord::Fate::NotReached;
  *record_ = attempt;
  rewriter_.setRecord(record_);
  const std::uint64_t firstModule = output.size();
  const std::uint64_t firstParameter = output.parameterCount();
  const Outcome outcome = rewrite(tables, old, module, offset, draw, output);
  rewriter_.setRecord(nullptr);
  if (module + outcome.modules <= record_->module) {
    // it ended before the module asked for
    *record_ = {};
    record_->module = attempt.module;
    return outcome;
  }
  record_->consumed = outcome.modules;
  record_->fate = outcome.fate == Fate::Rewritten ? ModuleRecord::Fate::Rewritten
                  : outcome.fate == Fate::Copied  ? ModuleRecord::Fate::Copied
                                                  : ModuleRecord::Fate::Cut;
  record_->result.appendAll(output.types().subspan(firstModule), output.parameters().subspan(firstParameter));
  return outcome;
}

void Derivation::Implementation::recordCut(const StringPart& part) {
  if (record_ != nullptr && part.firstModule <= record_->module && record_->module < part.endModule) {
    record_->fate = ModuleRecord::Fate::CutAway;
    record_->cutBy = part.firstModule - 1;
  }
}

}  // namespace espalier::derivation

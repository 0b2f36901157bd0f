#include "engine/derivation/scan/module_rewriter.h"

#include <algorithm>

namespace espalier::derivation {

ModuleRewriter::Outcome ModuleRewriter::rewriteSilently(const SystemTables& tables, const ScanPlace& place, double draw,
                                                        ModuleString& output) {
  ScanContext& context = *context_;
  const ModuleString& old = *context.old;
  const std::uint64_t module = place.module;
  const core::ModuleTypeId type = old.types()[module];
  const PredecessorPlace predecessor{old.types().data(), old.parameters().data(), old.size(), module, place.offset};
  Surroundings surroundings{module, place.offset, 0, 0, true};
  const language::LSystem& system = *tables.system;
  context.evaluator.setModule(module, type);

  // the right context of decomposition in a successor begins behind the whole predecessor
  const auto consume = [&](const language::Production& production) {
    const Outcome outcome{production.predecessor.size(), context.rewriter.parameterCount(production), Fate::Rewritten};
    surroundings.right = module + outcome.modules;
    surroundings.rightOffset = place.offset + outcome.parameters;
    return outcome;
  };
  const auto applyNested = [&](const language::Production& production, std::uint32_t depth) {
    surroundings.isBehindPredecessor = false;
    context.rewriter.applyNested(production, system.decomposition, tables.rules, surroundings, depth, false,
                                 core::DrawDomain::Decomposition, context.step, module, output);
  };

  // a production
  const language::ProductionList& list = system.productions;
  if (!list.index.empty() && !list.index.candidates(type).empty()) {
    context.random.key(core::DrawDomain::Production, context.step, module);
    const language::Production* production =
        system.isStochastic
            ? context.rewriter.chooseByWeights(list, tables.rules, predecessor, surroundings, context.step, draw)
            : context.rewriter.chooseFirst(list, tables.rules, predecessor, surroundings);
    if (production != nullptr) {
      const Outcome outcome = consume(*production);
      if (tables.decomposes[static_cast<std::size_t>(production - list.productions.data())] != 0) {
        applyNested(*production, 0);
      } else {
        context.rewriter.apply(*production, output);
      }
      return outcome;
    }
  }

  // decomposition of the module itself
  if (tables.hasDecomposition && !system.decomposition.index.candidates(type).empty()) {
    context.random.key(core::DrawDomain::Decomposition, context.step, module);
    if (const language::Production* production =
            context.rewriter.chooseFirst(system.decomposition, tables.rules, predecessor, surroundings)) {
      const Outcome outcome = consume(*production);
      applyNested(*production, 1);
      return outcome;
    }
  }

  const std::size_t arity = context.program.arity[type];
  if (context.cuts.isCut(type)) {
    return {1, arity, Fate::Cut};
  }
  output.append(type, old.parameters().subspan(place.offset, arity));
  return {1, arity, Fate::Copied};
}

void ModuleRewriter::rewriteNext(const SystemTables& tables, double draw, ScanPlace& place) {
  const Outcome outcome = rewrite(tables, place, draw, context_->output);
  if (outcome.fate == Fate::Cut) {
    const StringPart part = cut(place);
    place = {part.endModule, part.endParameter};
  } else {
    place.module += outcome.modules;
    place.offset += outcome.parameters;
  }
}

StringPart ModuleRewriter::cut(const ScanPlace& place) {
  const StringPart part = findCutPart(context_->program, context_->old->types(), place.module, place.offset);
  cut(place, part);
  return part;
}

void ModuleRewriter::cut(const ScanPlace& place, const StringPart& part) {
  ModuleRecord* const record = context_->record;
  if (record != nullptr && part.firstModule <= record->module && record->module < part.endModule) {
    record->fate = ModuleRecord::Fate::CutAway;
    record->cutBy = place.module;
  }
  context_->cuts.add(*context_->old, part, place.offset);
}

std::size_t ModuleRewriter::longestPredecessor(const SystemTables& tables) const {
  // from right to left, no predecessor reaches over the module behind its first
  if (context_->tables.front().isProducedBackwards && !context_->program.hasSubSystems) {
    return 1;
  }
  std::size_t longest = 1;
  for (const language::ProductionList* list : {&tables.system->productions, &tables.system->decomposition}) {
    for (const language::Production& production : list->productions) {
      longest = std::max(longest, production.predecessor.size());
    }
  }
  return longest;
}

ModuleRewriter::Outcome ModuleRewriter::rewriteRecorded(const SystemTables& tables, const ScanPlace& place, double draw,
                                                        ModuleString& output) {
  ModuleRecord& record = *context_->record;
  const std::uint64_t module = place.module;
  // only a predecessor of several modules reaches from an earlier module to the recorded one
  if (module > record.module || record.module - module >= longestPredecessor(tables)) {
    return rewriteSilently(tables, place, draw, output);
  }

  ModuleRecord attempt;
  attempt.module = record.module;
  attempt.first = module;
  attempt.system = tables.system;
  attempt.fate = module == attempt.module ? ModuleRecord::Fate::Unfinished : ModuleRecord::Fate::NotReached;
  record = attempt;
  context_->rewriter.setRecord(&record);
  const std::uint64_t firstModule = output.size();
  const std::uint64_t firstParameter = output.parameterCount();
  const Outcome outcome = rewriteSilently(tables, place, draw, output);
  context_->rewriter.setRecord(nullptr);
  if (module + outcome.modules <= record.module) {
    // the predecessor ends before the recorded module
    record = {};
    record.module = attempt.module;
    return outcome;
  }
  record.consumed = outcome.modules;
  record.fate = outcome.fate == Fate::Rewritten ? ModuleRecord::Fate::Rewritten
                : outcome.fate == Fate::Copied  ? ModuleRecord::Fate::Copied
                                                : ModuleRecord::Fate::Cut;
  record.result.appendAll(output.types().subspan(firstModule), output.parameters().subspan(firstParameter));
  return outcome;
}

}  // namespace espalier::derivation

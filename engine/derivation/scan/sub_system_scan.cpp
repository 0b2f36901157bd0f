#include "engine/derivation/scan/sub_system_scan.h"

#include <utility>

#include "engine/core/check.h"

namespace espalier::derivation {

void SubSystemScan::run() {
  ScanContext& context = *context_;
  const std::span<const core::ModuleTypeId> types = context.old->types();
  origins_.clear();
  movedOrigins_.clear();
  nextCall_ = 1;
  for (ScanPlace place; place.module < types.size();) {
    if ((place.module & 0xFFFU) == 0) {
      context.evaluator.pollCancelled();
    }
    // a `$` belongs to the caller
    if (types[place.module] == context.program.subSystemEnd && calls_->stack().depth() > 1) {
      calls_->leave();
    }
    rewriteNext(place);
    context.rewriter.checkSize(context.output.size(), context.output.parameterCount());
  }
  // calls that the string does not close
  while (calls_->stack().depth() > 1) {
    calls_->leave();
  }
  makeInstances();
}

void SubSystemScan::rewriteNext(ScanPlace& place) {
  ScanContext& context = *context_;
  const SystemTables& tables = context.tables[calls_->stack().state().system];
  const double draw =
      context.drawsEachPosition(*tables.system) ? context.random.selection(context.step, place.module) : 0.0;
  const bool isCall = calls_->isCall(context.old->types()[place.module]);
  const std::uint64_t firstModule = context.output.size();
  const std::uint64_t firstParameter = context.output.parameterCount();
  const ModuleRewriter::Outcome outcome = rewriter_->rewrite(tables, place, draw, context.output);
  const std::uint32_t instance = nextCall_;
  nextCall_ += isCall ? 1 : 0;

  if (outcome.fate == ModuleRewriter::Fate::Cut) {
    const StringPart part = findCut(place);
    rewriter_->cut(place, part);
    place = {part.endModule, part.endParameter};
    return;
  }
  if (outcome.fate == ModuleRewriter::Fate::Rewritten) {
    addFreshCalls(firstModule, firstParameter);
    // the call of a module that was rewritten is gone
    if (isCall) {
      calls_->stack().push(instance);
      calls_->end();
      calls_->stack().pop();
    }
  } else if (isCall) {
    ESPALIER_CHECK(instance < context.plant->instances.size());
    origins_.push_back({false, instance});
    calls_->enter(instance);
  }
  context.noteOrigins(place.module, place.module + outcome.modules, firstModule);
  place.module += outcome.modules;
  place.offset += outcome.parameters;
}

StringPart SubSystemScan::findCut(const ScanPlace& place) {
  // as CutParts::find, but a `$` of the call around ends the part as well, and calls inside end, unless `%(p)` keeps
  // the part
  const language::Program& program = context_->program;
  const std::span<const core::ModuleTypeId> types = context_->old->types();
  const bool isKept = context_->cuts.keepsPart(types[place.module]);
  StringPart part{place.module + 1, place.module + 1, place.offset + program.arity[types[place.module]], 0};
  part.endParameter = part.firstParameter;
  CallStack& stack = calls_->stack();
  const std::size_t outerDepth = stack.depth();
  std::uint64_t branchDepth = 0;
  const auto removeCall = [&] {
    if (!isKept) {
      calls_->end();
    }
    stack.pop();
  };
  for (; part.endModule < types.size(); ++part.endModule) {
    const core::ModuleTypeId type = types[part.endModule];
    if (type == program.openBranch) {
      ++branchDepth;
    } else if (type == program.closeBranch) {
      if (branchDepth == 0) {
        break;
      }
      --branchDepth;
    } else if (calls_->isCall(type)) {
      if (isKept) {
        movedOrigins_.push_back({false, nextCall_});
      }
      stack.push(nextCall_++);
    } else if (type == program.subSystemEnd) {
      if (stack.depth() > outerDepth) {
        removeCall();
      } else if (outerDepth > 1) {
        break;
      }
    }
    part.endParameter += program.arity[type];
  }
  while (stack.depth() > outerDepth) {
    removeCall();
  }
  return part;
}

void SubSystemScan::addFreshCalls(std::uint64_t firstModule, std::uint64_t firstParameter) {
  const ModuleString& output = context_->output;
  std::uint64_t offset = firstParameter;
  for (std::uint64_t i = firstModule; i < output.size(); ++i) {
    const core::ModuleTypeId type = output.types()[i];
    if (calls_->isCall(type)) {
      origins_.push_back({true, calls_->systemOfCall(output.parameters()[offset])});
    }
    offset += context_->program.arity[type];
  }
}

void SubSystemScan::makeInstances() {
  // parts that `%(p)` cuts go to the end of the string, and so do their calls
  origins_.insert(origins_.end(), movedOrigins_.begin(), movedOrigins_.end());
  std::vector<InstanceState>& old = context_->plant->instances;
  std::vector<InstanceState> instances;
  instances.reserve(origins_.size() + 1);
  instances.push_back(std::move(old.front()));
  for (const Origin& origin : origins_) {
    instances.push_back(origin.isFresh ? makeInstance(context_->program, origin.index) : std::move(old[origin.index]));
  }
  old = std::move(instances);
  calls_->begin();
}

}  // namespace espalier::derivation

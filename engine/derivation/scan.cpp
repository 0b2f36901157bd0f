#include <algorithm>
#include <array>
#include <cstring>
#include <span>

#include "engine/derivation/implementation.h"

namespace espalier::derivation {
namespace {

// old modules between two looks at the limits and at `cancelled`
constexpr std::uint64_t kChunkModules = 4096;
// new modules that one chunk may make before the limits are looked at
constexpr std::uint64_t kChunkOutput = 65536;
// modules or parameters that may be written beyond the end of what is used
constexpr std::uint64_t kSlack = 64;
// parameters that are copied in one move, whether there are as many or not
constexpr std::uint64_t kCopiedAtOnce = 4;

}  // namespace

void Derivation::Implementation::reserveOutput(std::uint64_t moduleCount, std::uint64_t parameterCount) {
  core::Buffer<core::ModuleTypeId>& types = working_.typeBuffer();
  core::Buffer<double>& parameters = working_.parameterBuffer();
  if (moduleCount > types.capacity()) {
    types.reserve(std::max<std::uint64_t>(moduleCount, types.capacity() + types.capacity() / 2));
  }
  if (parameterCount > parameters.capacity()) {
    parameters.reserve(std::max<std::uint64_t>(parameterCount, parameters.capacity() + parameters.capacity() / 2));
  }
}

void Derivation::Implementation::reserveEstimate(const ModuleString& old) {
  // memory that is reserved and never touched costs nothing, copying a string that outgrew its buffer does
  const auto estimate = [](std::uint64_t size, double growth, std::uint64_t bound) {
    const double wanted = static_cast<double>(size) * growth * 1.1;
    return std::min(wanted < 1.0e18 ? static_cast<std::uint64_t>(wanted) : bound, bound) + kSlack;
  };
  const std::uint64_t maximumBytes = options_.limits.maximumStringBytes;
  reserveOutput(estimate(old.size(), moduleGrowth_, std::min(options_.limits.maximumModules, maximumBytes / 2)),
                estimate(old.parameterCount(), parameterGrowth_, maximumBytes / 8));
}

void Derivation::Implementation::scan(PlantState& state) {
  const ModuleString& old = state.string;
  // signals run through strings whose branches stay where they are: the links of the step before
  areLinksKept_ = isWorkingIndexed_ && index_.isShared(working_.types(), old.types());
  isWorkingIndexed_ = false;
  working_.clear();
  keptParts_.clear();
  keptModules_.begin(old.earlierMark());
  const bool isParallel = canScanInParallel(old);
  const bool isParted = !isParallel && canScanInParts(old);
  const bool isIndexed = std::any_of(program_->systems.begin(), program_->systems.end(),
                                     [&](const language::LSystem& system) { return needsIndex(system); });
  if (isIndexed && !isParallel && !isParted && !areLinksKept_) {
    buildIndex(old);
  }
  const bool isBackwards = tables_.front().isProducedBackwards && !program_->hasSubSystems;
  shortcuts_.clear();
  // every sub-L-system has rules of its own
  LeftShortcuts* const shortcuts = program_->hasSubSystems ? nullptr : &shortcuts_;
  rewriter_.setStrings(
      {old.types().data(), old.parameters().data(), old.size(), old.parameterCount(), &index_, true, shortcuts},
      isBackwards ? nullptr : &working_, isBackwards ? &pieces_ : nullptr);
  reserveEstimate(old);
  if (program_->hasSubSystems) {
    scanWithCalls(state);
  } else if (isBackwards) {
    scanBackwards(state);
  } else if (record_ != nullptr) {
    scanRecorded(state);
  } else if (isParallel) {
    scanInParallel(state);
  } else if (isParted) {
    scanInParts(state);
  } else {
    ScanPlace place;
    if (usesBatches(old)) {
      scanInBatches(state, old.size(), place);
    } else {
      scanUpTo(state, old.size(), place);
    }
  }
  scannedModules_ += old.size();
  appendKeptParts(old);
  rewriter_.checkSize(working_.size(), working_.parameterCount());
  evaluator_.clearModule();
  if (old.size() > 0) {
    moduleGrowth_ = static_cast<double>(working_.size()) / static_cast<double>(old.size());
  }
  if (old.parameterCount() > 0) {
    parameterGrowth_ = static_cast<double>(working_.parameterCount()) / static_cast<double>(old.parameterCount());
  }
  isOldIndexed_ = isIndexed;
}

void Derivation::Implementation::scanUpTo(const PlantState& state, std::uint64_t end, ScanPlace& place) {
  if (random_.isSequential() && program_->systems.front().isStochastic) {
    hasParameters_ ? scanPlain<true, true>(state, end, place) : scanPlain<true, false>(state, end, place);
  } else {
    hasParameters_ ? scanPlain<false, true>(state, end, place) : scanPlain<false, false>(state, end, place);
  }
}

template <bool kDrawsEachPosition, bool kHasParameters>
void Derivation::Implementation::scanPlain(const PlantState& state, std::uint64_t end, ScanPlace& place) {
  const SystemTables& tables = tables_.front();
  const TypePlan* plans = tables.plan.plans();
  const QuickRule* rules = tables.plan.rules();
  const QuickValue* values = tables.plan.values();
  const core::ModuleTypeId* successors = tables.plan.types();
  const FixedBlocks& blocks = tables.batches.fixedBlocks();
  const ModuleString& old = state.string;
  const core::ModuleTypeId* types = old.types().data();
  const double* parameters = old.parameters().data();
  const std::uint64_t parameterCount = old.parameterCount();
  const std::uint64_t largestLength = tables.plan.largestLength();
  const std::uint64_t largestParameters = tables.plan.largestParameterCount();
  const std::uint64_t chunk =
      std::clamp<std::uint64_t>(kChunkOutput / std::max(largestLength, largestParameters), 1, kChunkModules);

  // the next module to read and its parameters, and where the next ones are written
  std::uint64_t module = place.module;
  std::uint64_t offset = place.offset;
  core::ModuleTypeId* nextType = nullptr;
  double* nextParameter = nullptr;
  const auto startWriting = [&](std::uint64_t moduleCount) {
    reserveOutput(working_.size() + moduleCount * largestLength + kSlack,
                  working_.parameterCount() + moduleCount * largestParameters + kSlack);
    nextType = working_.typeBuffer().data() + working_.size();
    nextParameter = working_.parameterBuffer().data() + working_.parameterCount();
  };
  const auto stopWriting = [&] {
    working_.typeBuffer().resize(static_cast<std::size_t>(nextType - working_.typeBuffer().data()));
    working_.parameterBuffer().resize(static_cast<std::size_t>(nextParameter - working_.parameterBuffer().data()));
  };
  const auto evaluate = [&](const QuickValue& value, double* codeFrame) {
    return value.form == QuickValue::Form::Code ? evaluator_.value(*value.expression, codeFrame)
                                                : quickValue(value, codeFrame);
  };

  while (module < end) {
    evaluator_.clearModule();
    evaluator_.pollCancelled();
    rewriter_.checkSize(working_.size(), working_.parameterCount());
    const std::uint64_t chunkEnd = std::min(end, module + chunk);
    startWriting(chunkEnd - module);
    if constexpr (!kDrawsEachPosition && !kHasParameters) {
      if (blocks.hasTable()) {
        nextType = blocks.write(types + module, chunkEnd - module, nextType,
                                working_.typeBuffer().data() + working_.typeBuffer().capacity());
        module = chunkEnd;
      }
    }
    while (module < chunkEnd) {
      const TypePlan& plan = plans[types[module]];
      double draw = 0.0;
      if constexpr (kDrawsEachPosition) {
        draw = random_.selection(step_, module);
      }

      // the same modules every time: written whole, however many of them count
      if (plan.kind == TypePlan::Kind::Fixed) [[likely]] {
        std::memcpy(nextType, plan.types.data(), sizeof(plan.types));
        if (plan.length > TypePlan::kInlineTypes) [[unlikely]] {
          std::memcpy(nextType, successors + plan.firstType, plan.length * sizeof(core::ModuleTypeId));
        }
        nextType += plan.length;
        if constexpr (kHasParameters) {
          if (plan.arity <= kCopiedAtOnce && offset + kCopiedAtOnce <= parameterCount) [[likely]] {
            std::memcpy(nextParameter, parameters + offset, kCopiedAtOnce * sizeof(double));
          } else if (plan.copied > 0) {
            std::memcpy(nextParameter, parameters + offset, plan.copied * sizeof(double));
          }
          nextParameter += plan.copied;
          offset += plan.arity;
        }
        ++module;
        continue;
      }

      if (plan.kind == TypePlan::Kind::General) {
        stopWriting();
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
        startWriting(chunkEnd > module ? chunkEnd - module : 0);
        continue;
      }

      // productions that only a condition and a weight decide between
      const double* formals = parameters + offset;
      double* frame = frame_.data();
      std::copy_n(formals, plan.arity, frame);
      if (plan.usesCode) {
        evaluator_.setModule(module, types[module]);
        if (plan.drawsRandom) {
          random_.key(core::DrawDomain::Production, step_, module);
        }
      }
      const QuickRule* chosen = nullptr;
      const QuickRule* const first = rules + plan.firstRule;
      const QuickRule* const last = first + plan.ruleCount;
      if (plan.kind == TypePlan::Kind::Rules) {
        for (const QuickRule* rule = first; rule != last; ++rule) {
          if (!rule->hasCondition || evaluate(rule->condition, frame) != 0.0) {
            chosen = rule;
            break;
          }
        }
      } else {
        chosen = chooseQuickRule(first, last, frame, module, draw);
      }

      // no production applies: the module stands for itself
      if (chosen == nullptr) {
        *nextType++ = types[module];
        std::copy_n(formals, plan.arity, nextParameter);
        nextParameter += plan.arity;
      } else {
        const core::ModuleTypeId* successor = successors + chosen->firstType;
        if (chosen->length <= TypePlan::kInlineTypes) [[likely]] {
          std::memcpy(nextType, successor, TypePlan::kInlineTypes * sizeof(core::ModuleTypeId));
        } else {
          std::memcpy(nextType, successor, chosen->length * sizeof(core::ModuleTypeId));
        }
        nextType += chosen->length;
        const QuickValue* value = values + chosen->firstValue;
        for (std::uint32_t i = 0; i < chosen->valueCount; ++i, ++value) {
          const double result = evaluate(*value, frame);
          if (rewriter_.storesFloats()) {
            *nextParameter++ = static_cast<double>(static_cast<float>(result));
          } else if (result - result == 0.0) [[likely]] {
            *nextParameter++ = result;
          } else {
            failQuickValue(*chosen, i, result, module, types[module]);
          }
        }
      }
      offset += plan.arity;
      ++module;
    }
    stopWriting();
  }
  place = {module, offset};
}

void Derivation::Implementation::scanBackwards(const PlantState& state) {
  const SystemTables& tables = tables_.front();
  const ModuleString& old = state.string;
  const bool drawsEachPosition = random_.isSequential() && tables.system->isStochastic;
  pieces_.clear();
  std::uint64_t offset = old.parameterCount();
  for (std::uint64_t module = old.size(); module-- > 0;) {
    if ((module & 0xFFFU) == 0) {
      evaluator_.pollCancelled();
    }
    offset -= program_->arity[old.types()[module]];
    pieces_.begin();
    const double draw = drawsEachPosition ? random_.selection(step_, module) : 0.0;
    const Outcome outcome = rewriteModule(tables, old, module, offset, draw, pieces_.modules());
    if (outcome.fate == Fate::Cut) {
      // what stands right of it in its branch has been made already
      const StringPart part = cutPart(old, module, offset);
      keepCutPart(old, part, offset);
      pieces_.dropBefore(part.endModule - part.firstModule);
    }
    rewriter_.checkSize(pieces_.modules().size(), pieces_.modules().parameterCount());
  }
  pieces_.appendTo(working_);
}

const QuickRule* Derivation::Implementation::chooseQuickRule(const QuickRule* first, const QuickRule* last,
                                                             double* frame, std::uint64_t module, double draw) {
  const auto evaluate = [&](const QuickValue& value) {
    return value.form == QuickValue::Form::Code ? evaluator_.value(*value.expression, frame) : quickValue(value, frame);
  };
  // the weights of the productions whose condition holds
  weights_.clear();
  quickMatches_.clear();
  double sum = 0.0;
  for (const QuickRule* rule = first; rule != last; ++rule) {
    if (!rule->hasCondition || evaluate(rule->condition) != 0.0) {
      const double weight = evaluate(rule->weight);
      weights_.push_back(weight);
      quickMatches_.push_back(rule);
      sum += weight;
    }
  }
  if (quickMatches_.size() < 2) {
    return quickMatches_.empty() ? nullptr : quickMatches_.front();
  }
  const bool usesFloats = rewriter_.storesFloats();
  if (!usesFloats && !(sum - sum == 0.0)) {
    rewriter_.failWeights(*quickMatches_.front()->production);
  }
  return quickMatches_[chooseByWeight(weights_, usesFloats ? draw : 1.0 - random_.selection(step_, module),
                                      usesFloats)];
}

void Derivation::Implementation::failQuickValue(const QuickRule& rule, std::uint32_t valueIndex, double value,
                                                std::uint64_t module, core::ModuleTypeId type) {
  // which parameter of which module of the successor it is
  evaluator_.setModule(module, type);
  std::uint32_t remaining = valueIndex;
  for (const language::SuccessorModule& made : rule.production->successor) {
    if (remaining < program_->arity[made.type]) {
      rewriter_.failNonFinite(value, rule.production->expressions[made.firstExpression + remaining], remaining,
                              made.type);
    }
    remaining -= program_->arity[made.type];
  }
  evaluator_.failHere(core::SimulationErrorCode::NonFinite, "a parameter is not finite");
}

Derivation::Implementation::Outcome Derivation::Implementation::rewrite(const SystemTables& tables,
                                                                        const ModuleString& old, std::uint64_t module,
                                                                        std::uint64_t offset, double draw,
                                                                        ModuleString& output) {
  const core::ModuleTypeId type = old.types()[module];
  const PredecessorPlace place{old.types().data(), old.parameters().data(), old.size(), module, offset};
  Surroundings surroundings{module, offset, 0, 0, true};
  const language::LSystem& system = *tables.system;
  evaluator_.setModule(module, type);

  // a production
  const language::ProductionList& list = system.productions;
  if (!list.index.empty() && !list.index.candidates(type).empty()) {
    random_.key(core::DrawDomain::Production, step_, module);
    const language::Production* production =
        system.isStochastic ? rewriter_.chooseByWeights(list, tables.rules, place, surroundings, step_, draw)
                            : rewriter_.chooseFirst(list, tables.rules, place, surroundings);
    if (production != nullptr) {
      const Outcome outcome{production->predecessor.size(), rewriter_.parameterCount(*production), Fate::Rewritten};
      if (tables.decomposes[static_cast<std::size_t>(production - list.productions.data())] != 0) {
        surroundings.right = module + outcome.modules;
        surroundings.rightOffset = offset + outcome.parameters;
        surroundings.isBehindPredecessor = false;
        rewriter_.applyNested(*production, system.decomposition, tables.rules, surroundings, 0, false,
                              core::DrawDomain::Decomposition, step_, module, output);
      } else {
        rewriter_.apply(*production, output);
      }
      return outcome;
    }
  }

  // decomposition of the module itself
  if (tables.hasDecomposition && !system.decomposition.index.candidates(type).empty()) {
    random_.key(core::DrawDomain::Decomposition, step_, module);
    if (const language::Production* production =
            rewriter_.chooseFirst(system.decomposition, tables.rules, place, surroundings)) {
      const Outcome outcome{production->predecessor.size(), rewriter_.parameterCount(*production), Fate::Rewritten};
      surroundings.right = module + outcome.modules;
      surroundings.rightOffset = offset + outcome.parameters;
      surroundings.isBehindPredecessor = false;
      rewriter_.applyNested(*production, system.decomposition, tables.rules, surroundings, 1, false,
                            core::DrawDomain::Decomposition, step_, module, output);
      return outcome;
    }
  }

  if (type == program_->cut || type == cutWithTurtle_) {
    return {1, program_->arity[type], Fate::Cut};
  }
  const std::size_t arity = program_->arity[type];
  output.append(type, old.parameters().subspan(offset, arity));
  return {1, arity, Fate::Copied};
}

Derivation::Implementation::StringPart Derivation::Implementation::cutPart(const ModuleString& old,
                                                                           std::uint64_t module,
                                                                           std::uint64_t offset) const {
  // from behind the cut to the `]` of the branch it is in, or to the end of the string
  const std::span<const core::ModuleTypeId> types = old.types();
  StringPart part{module + 1, module + 1, offset + program_->arity[types[module]], 0};
  part.endParameter = part.firstParameter;
  std::uint64_t depth = 0;
  for (; part.endModule < types.size(); ++part.endModule) {
    const core::ModuleTypeId type = types[part.endModule];
    if (type == program_->openBranch) {
      ++depth;
    } else if (type == program_->closeBranch) {
      if (depth == 0) {
        break;
      }
      --depth;
    }
    part.endParameter += program_->arity[type];
  }
  return part;
}

void Derivation::Implementation::keepCutPart(const ModuleString& old, const StringPart& part, std::uint64_t offset) {
  recordCut(part);
  if (old.types()[part.firstModule - 1] == cutWithTurtle_) {
    keptParts_.push_back({part, old.parameters()[offset]});
  }
}

void Derivation::Implementation::appendKeptParts(const ModuleString& old) {
  if (keptParts_.empty()) {
    return;
  }
  if (keptCut_ == core::kNoModuleType) {
    evaluator_.warn("a part cut by %(p) is dropped: no %(p,n) occurs in the model to append it behind", {});
    return;
  }
  // numbered after those that are in the string already
  const std::span<const core::ModuleTypeId> made = working_.types();
  auto number = static_cast<double>(std::count(made.begin(), made.end(), keptCut_));
  for (const KeptPart& kept : keptParts_) {
    const std::array<double, 2> parameters{kept.parameter, number};
    working_.append(keptCut_, parameters);
    working_.appendAll(
        old.types().subspan(kept.part.firstModule, kept.part.endModule - kept.part.firstModule),
        old.parameters().subspan(kept.part.firstParameter, kept.part.endParameter - kept.part.firstParameter));
    number += 1.0;
  }
}

}  // namespace espalier::derivation

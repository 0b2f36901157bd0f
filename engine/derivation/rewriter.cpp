#include "engine/derivation/rewriter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/derivation/matching/production_plan.h"

namespace espalier::derivation {

using language::Production;
using language::ProductionList;

Rewriter::Rewriter(const language::Program& program, Evaluator& evaluator, RandomSource& random,
                   const core::Limits& limits)
    : program_(&program),
      evaluator_(&evaluator),
      random_(&random),
      limits_(&limits),
      storesFloats_(program.compatibility != core::Compatibility::Espalier),
      producedIndex_(program),
      frames_(program.maximumSlots + std::size_t{1}, 0.0),
      chosenFrame_(frames_.data()) {}

void Rewriter::setStrings(const ContextString& around, const ModuleString* produced, ProducedPieces* pieces) {
  around_ = around;
  produced_ = produced;
  pieces_ = pieces;
  producedIndex_.clear();
  producedShortcuts_.clear();
}

bool Rewriter::matchesShape(const Production& production, const ContextRules& rules, const PredecessorPlace& place,
                            const Surroundings& surroundings, double* frame, CandidateRecord* record) {
  using Result = CandidateRecord::Result;
  const auto differs = [record](Result result, std::size_t module) {
    if (record != nullptr) {
      record->result = result;
      record->predecessorModule = module;
    }
    return false;
  };
  // the strict predecessor: contiguous modules of equal type
  const std::size_t length = production.predecessor.size();
  // from right to left, the modules behind the first are rewritten already
  if (place.size - place.module < length || (pieces_ != nullptr && length > 1 && place.types == around_.types)) {
    return differs(Result::Predecessor, place.size - place.module < length ? place.size - place.module : 1);
  }
  std::uint64_t offset = place.offset;
  for (std::size_t i = 0; i < length; ++i) {
    const language::FormalModule& formal = production.predecessor[i];
    const core::ModuleTypeId type = place.types[place.module + i];
    if (type != formal.type || (i > 0 && !isBarrier_.empty() && isBarrier_[type] != 0)) {
      return differs(Result::Predecessor, i);
    }
    const std::size_t arity = program_->arity[type];
    for (std::size_t k = 0; k < arity; ++k) {
      frame[formal.firstSlot + k] = place.parameters[offset + k];
    }
    offset += arity;
  }
  // right context, then left context
  if (!production.rightContext.empty()) {
    const bool isBehind = surroundings.isBehindPredecessor;
    if (!matchesRight(
            *program_, rules, around_, production.rightContext, isBehind ? place.module + length : surroundings.right,
            isBehind ? offset : surroundings.rightOffset, frame, record == nullptr ? nullptr : &record->rightLooks)) {
      return differs(Result::RightContext, 0);
    }
  }
  return production.leftContext.empty() ||
         matchesLeft(*program_, rules, around_, production.leftContext, surroundings.left, surroundings.leftOffset,
                     frame, record == nullptr ? nullptr : &record->leftLooks) ||
         differs(Result::LeftContext, 0);
}

bool Rewriter::matchesProduced(const Production& production, const ContextRules& rules, double* frame) {
  if (!production.newRightContext.empty() &&
      (pieces_ == nullptr || !pieces_->matchesRight(rules, production.newRightContext, frame))) {
    return false;
  }
  if (production.newLeftContext.empty()) {
    return true;
  }
  if (produced_ == nullptr) {
    return false;
  }
  producedIndex_.extend(*produced_);
  const ContextString produced{produced_->types().data(), produced_->parameters().data(),
                               produced_->size(),         produced_->parameterCount(),
                               &producedIndex_,           false,
                               &producedShortcuts_};
  return matchesLeft(*program_, rules, produced, production.newLeftContext, produced.size, produced.parameterCount,
                     frame);
}

bool Rewriter::matches(const Production& production, const ContextRules& rules, const PredecessorPlace& place,
                       const Surroundings& surroundings, double* frame) {
  CandidateRecord* record = nullptr;
  if (record_ != nullptr) {
    record = &record_->searches.back().candidates.emplace_back();
    record->production = &production;
  }
  if (!matchesShape(production, rules, place, surroundings, frame, record)) {
    return false;
  }
  if ((!production.newLeftContext.empty() || !production.newRightContext.empty()) &&
      !matchesProduced(production, rules, frame)) {
    if (record != nullptr) {
      record->result = CandidateRecord::Result::ProducedContext;
    }
    return false;
  }
  if (!production.preBlock.empty()) {
    evaluator_->run(production.preBlock, frame);
  }
  if (record != nullptr) {
    return recordCondition(production, frame, *record);
  }
  return !production.condition || evaluator_->value(*production.condition, frame) != 0.0;
}

SearchRecord& Rewriter::beginSearch(const ProductionList& list, const PredecessorPlace& place, std::uint32_t depth) {
  SearchRecord& search = record_->searches.emplace_back();
  search.list = &list;
  search.type = place.types[place.module];
  search.parameters.assign(place.parameters + place.offset,
                           place.parameters + place.offset + program_->arity[search.type]);
  search.depth = depth;
  return search;
}

bool Rewriter::recordCondition(const Production& production, double* frame, CandidateRecord& record) {
  record.formals.assign(frame, frame + production.slotCount);
  if (!production.condition) {
    return true;
  }
  record.condition = evaluator_->value(*production.condition, frame);
  const language::CodeRange code = production.condition->code;
  for (std::uint32_t i = code.begin; i < code.end; ++i) {
    if (auto variable = evaluator_->variableRead(program_->code[i])) {
      if (std::find(record.variables.begin(), record.variables.end(), *variable) == record.variables.end()) {
        record.variables.push_back(std::move(*variable));
      }
    }
  }
  if (*record.condition == 0.0) {
    record.result = CandidateRecord::Result::Condition;
  }
  return *record.condition != 0.0;
}

const Production* Rewriter::chooseFirst(const ProductionList& list, const ContextRules& rules,
                                        const PredecessorPlace& place, const Surroundings& surroundings) {
  chosenFrame_ = frames_.data();
  if (record_ != nullptr) {
    beginSearch(list, place, searchDepth_);
  }
  for (const std::uint32_t candidate : list.index.candidates(place.types[place.module])) {
    const Production& production = list.productions[candidate];
    if (matches(production, rules, place, surroundings, chosenFrame_)) {
      if (record_ != nullptr) {
        record_->searches.back().chosen = &production;
      }
      return &production;
    }
  }
  return nullptr;
}

const Production* Rewriter::chooseByWeights(const ProductionList& list, const ContextRules& rules,
                                            const PredecessorPlace& place, const Surroundings& surroundings,
                                            std::uint64_t step, double draw) {
  const std::span<const std::uint32_t> candidates = list.index.candidates(place.types[place.module]);
  const std::size_t frameSize = program_->maximumSlots + std::size_t{1};
  if (frames_.size() < candidates.size() * frameSize) {
    frames_.resize(candidates.size() * frameSize, 0.0);
  }
  if (record_ != nullptr) {
    beginSearch(list, place, searchDepth_).isStochastic = true;
  }
  // every match keeps a frame of its own until the choice
  matches_.clear();
  weights_.clear();
  double sum = 0.0;
  for (const std::uint32_t candidate : candidates) {
    const Production& production = list.productions[candidate];
    double* frame = frames_.data() + matches_.size() * frameSize;
    if (matches(production, rules, place, surroundings, frame)) {
      const double weight = production.probability ? evaluator_->value(*production.probability, frame) : 1.0;
      matches_.push_back(&production);
      weights_.push_back(weight);
      sum += weight;
      if (record_ != nullptr) {
        record_->searches.back().candidates.back().weight = weight;
      }
    }
  }
  if (matches_.empty()) {
    return nullptr;
  }
  std::size_t chosen = 0;
  if (matches_.size() > 1) {
    if (!storesFloats_ && !std::isfinite(sum)) {
      failWeights(*matches_.front());
    }
    const double number = storesFloats_ ? draw : 1.0 - random_->selection(step, place.module);
    chosen = chooseByWeight(weights_, number, storesFloats_);
    if (record_ != nullptr) {
      record_->searches.back().draw = number;
    }
  }
  if (record_ != nullptr) {
    record_->searches.back().chosen = matches_[chosen];
  }
  chosenFrame_ = frames_.data() + chosen * frameSize;
  return matches_[chosen];
}

void Rewriter::apply(const Production& production, ModuleString& output) {
  if (!production.postBlock.empty()) {
    evaluator_->run(production.postBlock, chosenFrame_);
  }
  const std::uint64_t firstModule = output.size();
  const std::uint64_t firstParameter = output.parameterCount();
  appendSuccessor(production, chosenFrame_, output);
  if (counts_ != nullptr) {
    ++(*counts_)[&production];
  }
  if (record_ != nullptr) {
    record_->searches.back().made.appendAll(output.types().subspan(firstModule),
                                            output.parameters().subspan(firstParameter));
  }
}

void Rewriter::appendSuccessor(const Production& production, double* frame, ModuleString& output) {
  core::Buffer<core::ModuleTypeId>& types = output.typeBuffer();
  core::Buffer<double>& parameters = output.parameterBuffer();
  for (const language::SuccessorModule& module : production.successor) {
    const std::size_t arity = program_->arity[module.type];
    for (std::size_t i = 0; i < arity; ++i) {
      const language::Expression& expression = production.expressions[module.firstExpression + i];
      parameters.push_back(stored(evaluator_->value(expression, frame), expression, i, module.type));
    }
    types.push_back(module.type);
  }
}

void Rewriter::applyNested(const Production& production, const ProductionList& list, const ContextRules& rules,
                           const Surroundings& surroundings, std::uint32_t depth, bool dropsCut,
                           core::DrawDomain domain, std::uint64_t step, std::uint64_t index, ModuleString& output) {
  // an earlier failure may have left modules here
  scratch_.clear();
  levels_.clear();
  searchDepth_ = 0;
  apply(production, scratch_);
  levels_.push_back({0, 0, 0, 0, scratch_.size(), depth, &production});
  // the first level belongs to another list of productions than the levels below
  if (depth == 0) {
    random_->key(domain, step, index);
  }
  rewriteLevels(list, rules, surroundings, dropsCut, output);
  searchDepth_ = 0;
}

void Rewriter::rewriteLevels(const ProductionList& list, const ContextRules& rules, const Surroundings& surroundings,
                             bool dropsCut, ModuleString& output) {
  const auto check = [&](const ModuleString& string, std::uint32_t depth, const Production& production) {
    const bool isTooLong = dropsCut && string.size() > limits_->maximumHomomorphismModules;
    if (!isTooLong && !isTooLarge(string.size(), string.parameterCount())) {
      return;
    }
    const std::string what =
        dropsCut ? "the output of the homomorphism for this module, at depth " + std::to_string(depth) + ","
                 : "the string";
    if (isTooLong) {
      // a bound of its own, because productions that always apply to their own output would fill the memory first
      evaluator_->failHere(core::SimulationErrorCode::LimitExceeded,
                           what + " has more than " + std::to_string(limits_->maximumHomomorphismModules) +
                               " modules (limit homomorphismModules): a smaller 'maximum depth' ends it earlier",
                           production.range);
    }
    failSize(string.size(), what, dropsCut ? production.range : core::SourceRange{});
  };
  std::uint64_t handled = 0;
  while (!levels_.empty()) {
    Level& level = levels_.back();
    if (level.module == level.end) {
      scratch_.typeBuffer().resize(level.firstModule);
      scratch_.parameterBuffer().resize(level.firstParameter);
      levels_.pop_back();
      continue;
    }
    if ((++handled & 0xFFFFU) == 0) {
      evaluator_->pollCancelled();
    }
    const core::ModuleTypeId type = scratch_.types()[level.module];
    const std::size_t arity = program_->arity[type];
    if (!list.index.empty() && !list.index.candidates(type).empty()) {
      const PredecessorPlace place{scratch_.types().data(), scratch_.parameters().data(), level.end, level.module,
                                   level.offset};
      searchDepth_ = level.depth;
      if (level.depth >= list.maximumDepth) {
        if (record_ != nullptr) {
          beginSearch(list, place, level.depth).isAtMaximumDepth = true;
        }
        warnAtDepth(list, rules, place, surroundings);
      } else if (const Production* production = chooseFirst(list, rules, place, surroundings)) {
        const std::uint32_t depth = level.depth + 1;
        if (depth > limits_->maximumRecursion) {
          evaluator_->failHere(
              core::SimulationErrorCode::LimitExceeded,
              "the nested rewriting is deeper than " + std::to_string(limits_->maximumRecursion) + " (limit recursion)",
              production->range);
        }
        level.module += production->predecessor.size();
        level.offset += parameterCount(*production);
        const std::uint64_t first = scratch_.size();
        const std::uint64_t firstParameter = scratch_.parameterCount();
        apply(*production, scratch_);
        check(scratch_, level.depth, *production);
        levels_.push_back({first, firstParameter, first, firstParameter, scratch_.size(), depth, production});
        continue;
      }
    }
    if (!(dropsCut && program_->nameOf(type) == "%")) {
      output.append(type, scratch_.parameters().subspan(level.offset, arity));
      check(output, level.depth, *level.production);
    }
    level.module += 1;
    level.offset += arity;
  }
}

void Rewriter::warnAtDepth(const ProductionList& list, const ContextRules& rules, const PredecessorPlace& place,
                           const Surroundings& surroundings) {
  if (!list.warnsAtDepth || hasWarnedAbout(list)) {
    return;
  }
  // this search must change nothing, so it skips productions whose match has side effects
  for (const std::uint32_t candidate : list.index.candidates(place.types[place.module])) {
    const Production& production = list.productions[candidate];
    if (!production.preBlock.empty() || (production.condition && !production.condition->isPure)) {
      continue;
    }
    if (matchesShape(production, rules, place, surroundings, frames_.data(), nullptr) &&
        (!production.condition || evaluator_->value(*production.condition, frames_.data()) != 0.0)) {
      warnedLists_.push_back(&list);
      evaluator_->warn("the maximum depth of " + std::to_string(list.maximumDepth) + " was reached while '" +
                           production.text + "' still applies",
                       production.range);
      return;
    }
  }
}

std::uint64_t Rewriter::parameterCount(const Production& production) const {
  std::uint64_t count = 0;
  for (const language::FormalModule& module : production.predecessor) {
    count += program_->arity[module.type];
  }
  return count;
}

bool Rewriter::isTooLarge(std::uint64_t moduleCount, std::uint64_t parameterCount) const {
  return moduleCount > limits_->maximumModules || moduleCount * 2 + parameterCount * 8 > limits_->maximumStringBytes;
}

void Rewriter::checkSize(std::uint64_t moduleCount, std::uint64_t parameterCount) const {
  if (isTooLarge(moduleCount, parameterCount)) {
    failSize(moduleCount, "the string", {});
  }
}

void Rewriter::failSize(std::uint64_t moduleCount, const std::string& what, core::SourceRange range) const {
  evaluator_->failHere(
      core::SimulationErrorCode::LimitExceeded,
      moduleCount > limits_->maximumModules
          ? what + " has more than " + std::to_string(limits_->maximumModules) + " modules (limit modules)"
          : what + " needs more than " + std::to_string(limits_->maximumStringBytes) + " bytes (limit stringBytes)",
      range);
}

void Rewriter::failWeights(const Production& production) const {
  evaluator_->failHere(core::SimulationErrorCode::NonFinite,
                       "the sum of the probabilities of the productions that apply is not finite", production.range);
}

void Rewriter::failNonFinite(double value, const language::Expression& expression, std::size_t position,
                             core::ModuleTypeId type) const {
  std::string what = "parameter " + std::to_string(position + 1);
  if (!evaluator_->place().hasModule || evaluator_->place().type != type) {
    what += " of '" + std::string(program_->nameOf(type)) + "'";
  }
  what += std::string(" became ") + nonFiniteName(value) + " in '" + sourceText(*program_, expression.range) + "'";
  evaluator_->failHere(core::SimulationErrorCode::NonFinite, what, expression.range);
}

}  // namespace espalier::derivation

// The choice among several rules that apply, by weights and draws.
#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <utility>

#include "engine/core/check.h"
#include "engine/derivation/batch/batch_rewriter.h"
#include "engine/derivation/matching/production_plan.h"

namespace espalier::derivation {

void BatchRewriter::loadDraws() {
  if (!areDrawsLoaded_) {
    areDrawsLoaded_ = true;
    const std::uint64_t block = first_ / 4;
    // a part that is cut may carry the end far beyond the last site
    const std::uint64_t end = std::min(end_, first_ + kChunkModules);
    step_.selection.selectionWords(step_.number, block, (end + 3) / 4 - block, words_.data());
  }
}

double BatchRewriter::draw(std::uint64_t module) {
  return areDrawsLoaded_ ? static_cast<double>(words_[module - first_ / 4 * 4]) * 0x1.0p-32
                         : step_.selection.selection(step_.number, module);
}

void BatchRewriter::chooseByThresholds(const BatchGroup& group, std::span<const std::uint32_t> sites) {
  const BatchRule* rules = plan_->rules().data() + group.firstRule;
  if (group.ruleCount == 1) {
    accept(*rules, match(*rules, sites));
    return;
  }
  // the draws of the whole chunk at once, unless few sites need them
  constexpr std::size_t kFew = 16;
  const bool areFew = sites.size() * kFew < end_ - first_;
  if (!areFew) {
    loadDraws();
  }
  const std::uint64_t firstWord = first_ / 4 * 4;
  bool needsLanes = false;
  for (std::uint32_t i = 0; i < group.ruleCount; ++i) {
    needsLanes = needsLanes || rules[i].needsLanes;
    isResized_ = isResized_ || plan_->blocks()[rules[i].block].isResizing;
  }
  // the blocks of a group's rules stand one after the other
  const std::uint32_t firstBlock = rules->block;
  const std::uint64_t* thresholds = group.thresholds.data();
  const std::size_t thresholdCount = group.thresholds.size();
  for (const std::uint32_t site : sites) {
    const std::uint64_t module = first_ + siteModule_[site];
    const std::uint64_t word =
        areFew ? static_cast<std::uint64_t>(step_.selection.selection(step_.number, module) * 0x1.0p32)
               : words_[module - firstWord];
    std::uint32_t chosen = 0;
    for (std::size_t k = 0; k < thresholdCount; ++k) {
      chosen += word < thresholds[k] ? 1 : 0;
    }
    siteBlock_[site] = firstBlock + chosen;
  }
  if (!needsLanes) {
    return;
  }
  for (std::uint32_t i = 0; i < group.ruleCount; ++i) {
    if (!rules[i].needsLanes) {
      continue;
    }
    std::size_t lane = laneCount_;
    for (const std::uint32_t site : sites) {
      laneSite_[lane] = site;
      lane += siteBlock_[site] == rules[i].block ? 1 : 0;
    }
    accept(rules[i], lane - laneCount_);
  }
}

void BatchRewriter::chooseByWeights(const BatchGroup& group, std::span<const std::uint32_t> sites) {
  constexpr std::size_t kLanes = ColumnEvaluator::kLanes;
  const BatchRule* rules = plan_->rules().data() + group.firstRule;
  weights_.resize(plan_->largestRuleCount() * kLanes);
  isMatched_.resize(plan_->largestRuleCount() * kLanes);
  chosenRule_.resize(kLanes);
  drawsBefore_.resize(plan_->largestRuleCount() * kLanes);
  candidateWeights_.resize(plan_->largestRuleCount());
  candidates_.resize(plan_->largestRuleCount());
  if (sites.size() * 8 > end_ - first_) {
    loadDraws();
  }
  for (std::size_t begin = 0; begin < sites.size(); begin += kLanes) {
    const std::span<const std::uint32_t> part = sites.subspan(begin, std::min(kLanes, sites.size() - begin));
    for (std::size_t i = 0; i < part.size(); ++i) {
      positions_[part[i]] = static_cast<std::uint32_t>(i);
    }
    // the rules that match at each site, and their weights
    std::fill_n(isMatched_.begin(), group.ruleCount * kLanes, std::uint8_t{0});
    for (std::uint32_t k = 0; k < group.ruleCount; ++k) {
      for (std::size_t i = 0; rules[k].drawsAgain && i < part.size(); ++i) {
        drawsBefore_[k * kLanes + i] = siteDraws_[part[i]].count;
      }
      std::size_t count = match(rules[k], part);
      count = keepWhereTrue(rules[k], count);
      if (count == 0) {
        continue;
      }
      setLanes(rules[k], laneCount_, count);
      loadKept(rules[k], laneCount_, count);
      const ColumnValue weight = evaluator_.value(rules[k].weight);
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t entry = k * kLanes + positions_[laneSite_[laneCount_ + i]];
        weights_[entry] = weight.values == nullptr ? weight.constant : weight.values[i];
        isMatched_[entry] = 1;
      }
    }
    // the choice, by the function of the other ways
    for (std::size_t i = 0; i < part.size(); ++i) {
      std::size_t count = 0;
      double sum = 0.0;
      for (std::uint32_t k = 0; k < group.ruleCount; ++k) {
        const bool isMatched = isMatched_[k * kLanes + i] != 0;
        candidateWeights_[count] = weights_[k * kLanes + i];
        candidates_[count] = k;
        sum += isMatched ? candidateWeights_[count] : 0.0;
        count += isMatched ? 1 : 0;
      }
      chosenRule_[i] = count == 0 ? group.ruleCount : candidates_[0];
      if (count > 1) {
        isUnusual_ = isUnusual_ || !(sum - sum == 0.0);
        chosenRule_[i] = candidates_[chooseByWeight({candidateWeights_.data(), count},
                                                    1.0 - draw(first_ + siteModule_[part[i]]), false)];
      }
    }
    // the lanes of the chosen rules: finding their neighbours again is cheaper than keeping all neighbours
    for (std::uint32_t k = 0; k < group.ruleCount; ++k) {
      std::size_t count = 0;
      for (std::size_t i = 0; i < part.size(); ++i) {
        remaining_[count] = part[i];
        count += chosenRule_[i] == k ? 1 : 0;
      }
      if (count > 0) {
        const std::size_t matched = match(rules[k], {remaining_.data(), count});
        if (!rules[k].hasBefore) {
          accept(rules[k], matched);
          continue;
        }
        // block and condition run again, with the same draws, and the condition holds for all
        const auto swapDraws = [&, sites = std::span(remaining_.data(), count)] {
          for (const std::uint32_t site : sites) {
            std::swap(siteDraws_[site].count, drawsBefore_[k * kLanes + positions_[site]]);
          }
        };
        if (rules[k].drawsAgain) {
          swapDraws();
        }
        const std::size_t kept = keepWhereTrue(rules[k], matched);
        if (rules[k].drawsAgain) {
          swapDraws();
        }
        accept(rules[k], kept);
      }
    }
  }
}

}  // namespace espalier::derivation

#include <algorithm>
#include <array>
#include <cstring>

#include "engine/core/check.h"
#include "engine/derivation/batch/batch_rewriter.h"
#include "engine/derivation/batch/unrolled.h"

namespace espalier::derivation {
namespace {

using core::ModuleTypeId;

// modules, or parameters, that one copy moves at least, however many count
constexpr std::uint64_t kTypesAtOnce = 24;
constexpr std::uint64_t kParametersAtOnce = 16;
// modules of a block that its record holds
constexpr std::uint64_t kBlockTypes = TypePlan::kInlineTypes;

/// Copies `count` elements, or `kAtOnce` when that is more: short stretches cost no branch.
template <std::uint64_t kAtOnce, typename T>
void copyStretch(T* target, const T* source, std::uint64_t count) {
  std::memcpy(target, source, kAtOnce * sizeof(T));
  if (count > kAtOnce) [[unlikely]] {
    std::uint64_t done = kAtOnce;
    if (count <= 4 * kAtOnce) {
      for (; done + kAtOnce <= count; done += kAtOnce) {
        std::memcpy(target + done, source + done, kAtOnce * sizeof(T));
      }
    }
    std::memcpy(target + done, source + done, (count - done) * sizeof(T));
  }
}

/// Whether all values are finite. A sum of differences x - x is 0 only then. With several sums, no addition waits for
/// the last addition.
bool areFinite(const double* values, std::size_t count) {
  std::array<double, 8> sums{};
  std::size_t i = 0;
  for (; i + sums.size() <= count; i += sums.size()) {
    for (std::size_t k = 0; k < sums.size(); ++k) {
      sums[k] += values[i + k] - values[i + k];
    }
  }
  for (; i < count; ++i) {
    sums[0] += values[i] - values[i];
  }
  return std::all_of(sums.begin(), sums.end(), [](double sum) { return sum == 0.0; });
}

}  // namespace

bool BatchRewriter::write(ModuleTypeId* types, double* parameters) {
  if (plan_->isFixedOnly()) {
    writeFixed(types, parameters);
    return true;
  }
  if (isResized_) {
    writeBlocks(types, parameters);
  } else {
    std::copy(step_.old.types + first_, step_.old.types + end_, types);
    std::copy(step_.old.parameters + offset_, step_.old.parameters + endOffset_, parameters);
  }
  const std::uint32_t* madeModule = isResized_ ? madeModule_.data() : siteModule_.data();
  bool isUsual = true;
  for (const RuleLanes& lanes : ruleLanes_) {
    if (lanes.rule->changesParts) {
      const ModuleTypeId type = plan_->blocks()[lanes.rule->block].types[0];
      for (std::size_t i = lanes.begin; i < lanes.begin + lanes.count; ++i) {
        types[madeModule[laneSite_[i]]] = type;
      }
    }
    isUsual = writeValues(lanes, parameters) && isUsual;
  }
  return isUsual && !evaluator_.isUnusual();
}

void BatchRewriter::writeBlocks(ModuleTypeId* types, double* parameters) const {
  const BatchBlock* blocks = blocks_.data();
  const ModuleTypeId* oldTypes = step_.old.types + first_;
  const double* oldParameters = step_.old.parameters + offset_;
  // modules and parameters that can be read and written from the beginning of the chunk
  const std::uint64_t readable = step_.old.size - first_;
  const std::uint64_t readableParameters = step_.old.parameterCount - offset_;
  const std::uint64_t made = madeModules_;
  const std::uint64_t madeParameters = madeParameters_;
  // local pointers: the compiler would read members again after each write, which may have changed them
  const std::uint32_t* const siteModule = siteModule_.data();
  const std::uint32_t* const siteOffset = siteOffset_.data();
  const std::uint32_t* const siteBlock = siteBlock_.data();
  const std::uint32_t* const resizing = resizing_.data();
  const std::size_t resizingCount = resizingCount_;

  // the first sites are so far from the ends that copies may move more modules than count
  std::size_t roomy = resizingCount;
  while (roomy > 0 && (madeModule_[resizing[roomy - 1]] + 2 * kTypesAtOnce > made ||
                       siteModule[resizing[roomy - 1]] + kTypesAtOnce > readable)) {
    --roomy;
  }

  std::uint64_t module = 0;  // next to read
  std::uint64_t offset = 0;
  std::uint64_t target = 0;  // next to write
  std::uint64_t targetOffset = 0;
  const auto copyUpTo = [&](std::uint64_t endModule, std::uint64_t endOffset) {
    std::copy(oldTypes + module, oldTypes + endModule, types + target);
    std::copy(oldParameters + offset, oldParameters + endOffset, parameters + targetOffset);
    target += endModule - module;
    targetOffset += endOffset - offset;
  };
  for (std::size_t i = 0; i < resizingCount; ++i) {
    const std::uint32_t site = resizing[i];
    const BatchBlock& block = blocks[siteBlock[site]];
    const std::uint64_t endModule = siteModule[site];
    const std::uint64_t endOffset = siteOffset[site];
    // the modules between the last site and this site, then the block; its parameters follow after all gaps
    if (i < roomy) [[likely]] {
      copyStretch<kTypesAtOnce>(types + target, oldTypes + module, endModule - module);
      target += endModule - module;
      if (endOffset != offset) {
        if (targetOffset + kParametersAtOnce <= madeParameters && offset + kParametersAtOnce <= readableParameters) {
          copyStretch<kParametersAtOnce>(parameters + targetOffset, oldParameters + offset, endOffset - offset);
        } else {
          std::copy(oldParameters + offset, oldParameters + endOffset, parameters + targetOffset);
        }
        targetOffset += endOffset - offset;
      }
      copyStretch<kBlockTypes>(types + target, block.length <= kBlockTypes ? block.types.data() : block.allTypes,
                               block.length);
    } else {
      copyUpTo(endModule, endOffset);
      std::copy_n(block.allTypes, block.length, types + target);
    }
    target += block.length;
    targetOffset += block.valueCount;
    module = endModule + block.readModules;
    offset = endOffset + block.readParameters;
  }
  copyUpTo(end_ - first_, endOffset_ - offset_);
  ESPALIER_CHECK(target == made && targetOffset == madeParameters);
}

bool BatchRewriter::staysAsItIs(std::size_t site) const {
  const BatchBlock& block = blocks_[siteBlock_[site]];
  return siteBlock_[site] == 0 || (block.length == 1 && block.valueCount == 0 && !block.isResizing &&
                                   block.allTypes[0] == step_.old.types[first_ + siteModule_[site]]);
}

void BatchRewriter::noteKept(std::uint64_t target, StepChanges& changes) const {
  const std::uint64_t modules = end_ - first_;
  if (plan_->isFixedOnly()) {
    noteKeptFixed(target, changes);
    return;
  }
  const std::uint32_t* const madeModule = isResized_ ? madeModule_.data() : siteModule_.data();
  const std::uint64_t made = isResized_ ? madeModules_ : modules;
  // between many sites the runs are too short: only the two ends are worth a look
  constexpr std::size_t kManySites = kChunkModules / StepChanges::kShortestRun;
  std::uint64_t from = 0;  // behind the last site that changes
  std::uint64_t to = 0;    // the same place of the result
  std::size_t site = 0;
  for (; site < siteCount_; ++site) {
    if (staysAsItIs(site)) {
      continue;
    }
    const std::uint64_t count = siteModule_[site] - from;
    if (count >= StepChanges::kShortestRun || from == 0) {
      changes.keep(first_ + from, target + to, count);
    }
    const BatchBlock& block = blocks_[siteBlock_[site]];
    from = siteModule_[site] + std::uint64_t{block.readModules};
    to = madeModule[site] + std::uint64_t{block.length};
    if (siteCount_ > kManySites) {
      break;
    }
  }
  if (site < siteCount_) {
    std::size_t last = siteCount_ - 1;
    while (last > site && staysAsItIs(last)) {
      --last;
    }
    const BatchBlock& block = blocks_[siteBlock_[last]];
    from = siteModule_[last] + std::uint64_t{block.readModules};
    to = madeModule[last] + std::uint64_t{block.length};
  }
  changes.keep(first_ + from, target + to, made - to);
}

void BatchRewriter::noteKeptFixed(std::uint64_t target, StepChanges& changes) const {
  const ModuleTypeId* const types = step_.old.types;
  const auto stays = [&](std::uint64_t module) { return plan_->classOf(types[module]) == BatchPlan::Class::Kept; };
  std::uint64_t first = first_;
  while (first < end_ && stays(first)) {
    ++first;
  }
  std::uint64_t last = end_;
  while (last > first && stays(last - 1)) {
    --last;
  }
  changes.keep(first_, target, first - first_);
  changes.keep(last, target + fixedModules_ - (end_ - last), end_ - last);
}

bool BatchRewriter::writeValues(const RuleLanes& lanes, double* parameters) {
  const BatchRule& rule = *lanes.rule;
  const std::uint32_t* const madeOffset = isResized_ ? madeOffset_.data() : siteOffset_.data();
  std::array<std::uint32_t, ColumnEvaluator::kLanes> places;
  std::uint32_t* const offsets = places.data();
  bool isFinite = true;
  for (std::size_t begin = lanes.begin; begin < lanes.begin + lanes.count; begin += ColumnEvaluator::kLanes) {
    const std::size_t count = std::min(ColumnEvaluator::kLanes, lanes.begin + lanes.count - begin);
    setLanes(rule, begin, count);
    loadKept(rule, begin, count);
    if (rule.hasBehind) {
      evaluator_.run(rule.behind);
      noteStores(rule, rule.behind, begin, count, true);
    }
    const std::uint32_t* const site = laneSite_.data() + begin;
    unrolled(count, [=](std::size_t i) { offsets[i] = madeOffset[site[i]]; });
    for (std::size_t k = 0; k < rule.values.size(); ++k) {
      const ColumnValue column = evaluator_.value(rule.values[k]);
      double* const target = parameters + k;
      if (column.values == nullptr) {
        const double value =
            step_.storesFloats ? static_cast<double>(static_cast<float>(column.constant)) : column.constant;
        isFinite = isFinite && (step_.storesFloats || value - value == 0.0);
        unrolled(count, [=](std::size_t i) { target[offsets[i]] = value; });
      } else if (step_.storesFloats) {
        for (std::size_t i = 0; i < count; ++i) {
          target[offsets[i]] = static_cast<double>(static_cast<float>(column.values[i]));
        }
      } else {
        isFinite = areFinite(column.values, count) && isFinite;
        const double* const values = column.values;
        unrolled(count, [=](std::size_t i) { target[offsets[i]] = values[i]; });
      }
    }
  }
  return isFinite;
}

}  // namespace espalier::derivation

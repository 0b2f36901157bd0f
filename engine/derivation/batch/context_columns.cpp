#include "engine/derivation/batch/context_columns.h"

namespace espalier::derivation {

using core::ModuleTypeId;
using language::ContextElement;

ContextColumns::ContextColumns(const language::Program& program, const ContextRules& rules, std::size_t laneCount)
    : program_(&program),
      rules_(&rules),
      areBracketsSeen_(!rules.isRing() && !rules.isIgnored(program.openBranch) &&
                       !rules.isIgnored(program.closeBranch)),
      modules_(laneCount),
      offsets_(laneCount),
      branches_(laneCount),
      insides_(laneCount) {
  for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
    const auto type = static_cast<ModuleTypeId>(i);
    const bool isOpen = type == program.openBranch;
    const bool isIgnored = rules.isIgnored(type);
    // a branch is passed as a whole, unless its bracket is ignored
    atModule_.push_back(isIgnored ? Move::Pass : isOpen ? Move::Leave : Move::Stop);
    atBranch_.push_back(isIgnored ? Move::Pass : Move::Stop);
    // brackets alone decide where the branch ends
    atBranchEnd_.push_back(type == program.closeBranch ? Move::Stop : isOpen ? Move::Leave : Move::Pass);
  }
}

void ContextColumns::findLeft(const ContextString& string, std::span<const ContextElement> context,
                              std::size_t firstElement, Lanes& lanes) {
  for (std::size_t i = 0; i < context.size() && lanes.laneCount > 0; ++i) {
    if (context[i].kind != ContextElement::Kind::Module) {
      lanes.laneCount = 0;
      return;
    }
    const ModuleTypeId sought = context[i].module.type;
    rules_->isRing() ? findLeftOf<true>(string, sought, firstElement + i, lanes)
                     : findLeftOf<false>(string, sought, firstElement + i, lanes);
  }
}

template <bool kIsRing>
void ContextColumns::findLeftOf(const ContextString& string, ModuleTypeId sought, std::size_t element, Lanes& lanes) {
  const ModuleTypeId* const types = string.types;
  const std::uint16_t* const arity = program_->arity.data();
  const std::uint8_t* const traits = rules_->traits();
  const ModuleTypeId openBranch = program_->openBranch;
  std::uint32_t* const sites = lanes.sites;
  std::uint64_t* const rows = lanes.rows;
  std::uint64_t* const places = lanes.places + element;
  std::uint64_t* const modules = modules_.data();
  std::uint64_t* const offsets = offsets_.data();
  const std::uint64_t laneCount = lanes.laneCount;
  std::uint64_t kept = 0;
  for (std::uint64_t lane = 0; lane < laneCount; ++lane) {
    std::uint64_t module = modules[lane];
    std::uint64_t offset = offsets[lane];
    ModuleTypeId found = core::kNoModuleType;
    // without a bound, the search would never end in a ring of ignored modules
    [[maybe_unused]] std::uint64_t remaining = string.size + 1;
    std::uint32_t passed = 0;
    while (true) {
      if (module == 0) {
        if (!kIsRing || !string.canWrap) {
          break;
        }
        module = string.size;
        offset = string.parameterCount;
      }
      if (kIsRing && --remaining == 0) {
        break;
      }
      --module;
      const ModuleTypeId type = types[module];
      const std::uint8_t trait = traits[type];
      offset -= arity[type];
      if (trait == 0) [[likely]] {
        found = type;
        break;
      }
      if ((trait & ContextRules::kCloseBranch) != 0) {
        const StringIndex::Link link = string.index->link(module);
        if (link.partner == StringIndex::kNone) {
          break;
        }
        module = link.partner;
        offset -= link.parameterCount;
      }
      // a search that has passed many modules goes on where an earlier search has ended
      if (++passed > LeftShortcuts::kNearModules && string.shortcuts != nullptr && types[module] == openBranch) {
        const LeftShortcuts::Place end = string.shortcuts->follow(*program_, *rules_, string, {module, offset});
        module = end.module;
        offset = end.offset;
        passed = 0;
      }
    }
    const std::uint64_t row = rows[lane];
    places[row] = offset;
    sites[kept] = sites[lane];
    rows[kept] = row;
    modules[kept] = module;
    offsets[kept] = offset;
    kept += found == sought ? 1 : 0;
  }
  lanes.laneCount = kept;
}

void ContextColumns::findRight(const ContextString& string, std::span<const ContextElement> context,
                               std::size_t firstElement, Lanes& lanes) {
  bool isEntered = false;  // a bracket of the context has entered the branch whose end is sought
  for (std::size_t i = 0; i < context.size() && lanes.laneCount > 0; ++i) {
    const ContextElement& element = context[i];
    const bool isBranchEnd = element.kind == ContextElement::Kind::SkipToBranchEnd;
    const bool entersBranch = element.kind == ContextElement::Kind::OpenBranch;
    if (isBranchEnd && isEntered) {
      moveToBranchEnds(string, lanes.laneCount);
    }
    const Move* const moves = (isBranchEnd ? atBranchEnd_ : entersBranch ? atBranch_ : atModule_).data();
    const ModuleTypeId sought = isBranchEnd ? core::kNoModuleType : element.module.type;
    rules_->isRing() ? findRightOf<true>(string, moves, sought, firstElement + i, lanes)
                     : findRightOf<false>(string, moves, sought, firstElement + i, lanes);
    if (!isBranchEnd && (sought == program_->openBranch || sought == program_->closeBranch)) {
      isEntered = entersBranch && areBracketsSeen_;
    }
  }
}

void ContextColumns::moveToBranchEnds(const ContextString& string, std::size_t laneCount) {
  for (std::size_t lane = 0; lane < laneCount; ++lane) {
    const StringIndex::Link link = string.index->link(branches_[lane]);
    if (link.partner != StringIndex::kNone) {
      modules_[lane] = link.partner;
      offsets_[lane] = insides_[lane] + link.parameterCount;
    }
  }
}

template <bool kIsRing>
void ContextColumns::findRightOf(const ContextString& string, const Move* moves, ModuleTypeId sought,
                                 std::size_t element, Lanes& lanes) {
  const ModuleTypeId* const types = string.types;
  const std::uint16_t* const arity = program_->arity.data();
  const bool isAnyStopRight = sought == core::kNoModuleType;
  const bool isOpen = sought == program_->openBranch;
  // the end of a branch is reached, not passed
  const std::uint64_t step = isAnyStopRight ? 0 : 1;
  const std::uint64_t size = string.size;
  std::uint32_t* const sites = lanes.sites;
  std::uint64_t* const rows = lanes.rows;
  std::uint64_t* const places = lanes.places + element;
  std::uint64_t* const modules = modules_.data();
  std::uint64_t* const offsets = offsets_.data();
  std::uint64_t* const branches = branches_.data();
  std::uint64_t* const insides = insides_.data();
  const std::uint64_t behind = isAnyStopRight ? 0 : arity[sought];
  const std::uint64_t laneCount = lanes.laneCount;
  std::uint64_t kept = 0;
  for (std::uint64_t lane = 0; lane < laneCount; ++lane) {
    std::uint64_t module = modules[lane];
    std::uint64_t offset = offsets[lane];
    bool isFound = false;
    [[maybe_unused]] std::uint64_t remaining = size + 1;
    while (true) {
      if (module >= size) {
        if (!kIsRing || size == 0) {
          break;
        }
        module = 0;
        offset = 0;
      }
      if (kIsRing && --remaining == 0) {
        break;
      }
      const ModuleTypeId type = types[module];
      const Move move = moves[type];
      if (move == Move::Stop) [[likely]] {
        isFound = isAnyStopRight || type == sought;
        break;
      }
      if (move == Move::Pass) {
        offset += arity[type];
        ++module;
        continue;
      }
      const StringIndex::Link link = string.index->link(module);
      if (link.partner == StringIndex::kNone) {
        break;
      }
      module = link.partner + 1;
      offset += link.parameterCount;
    }
    const std::uint64_t row = rows[lane];
    places[row] = offset;
    sites[kept] = sites[lane];
    rows[kept] = row;
    modules[kept] = module + step;
    offsets[kept] = offset + behind;
    branches[kept] = isOpen ? module : branches[lane];
    insides[kept] = isOpen ? offset + behind : insides[lane];
    kept += isFound ? 1 : 0;
  }
  lanes.laneCount = kept;
}

}  // namespace espalier::derivation

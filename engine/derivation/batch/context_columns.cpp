#include "engine/derivation/batch/context_columns.h"

namespace espalier::derivation {

using core::ModuleTypeId;
using language::ContextElement;

ContextColumns::ContextColumns(const language::Program& program, const ContextRules& rules, std::size_t laneCount)
    : program_(&program),
      rules_(&rules),
      areBracketsSeen_(!rules.isRing() && !rules.isIgnored(program.openBranch) &&
                       !rules.isIgnored(program.closeBranch)),
      found_(laneCount),
      places_(laneCount),
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
                              std::size_t firstElement, std::uint64_t* places) {
  for (std::size_t i = 0; i < context.size() && foundCount_ > 0; ++i) {
    if (context[i].kind != ContextElement::Kind::Module) {
      foundCount_ = 0;
      return;
    }
    const ModuleTypeId sought = context[i].module.type;
    rules_->isRing() ? findLeftOf<true>(string, sought, places + firstElement + i)
                     : findLeftOf<false>(string, sought, places + firstElement + i);
  }
}

template <bool kIsRing>
void ContextColumns::findLeftOf(const ContextString& string, ModuleTypeId sought, std::uint64_t* places) {
  const ModuleTypeId* const types = string.types;
  const std::uint16_t* const arity = program_->arity.data();
  const std::uint8_t* const traits = rules_->traits();
  const ModuleTypeId openBranch = program_->openBranch;
  std::uint32_t* const alive = found_.data();
  Place* const ends = places_.data();
  const std::size_t rowSize = rowSize_;
  const std::size_t count = foundCount_;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t search = alive[i];
    std::uint64_t module = ends[search].module;
    std::uint64_t offset = ends[search].offset;
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
    places[search * rowSize] = offset;
    ends[search] = {module, offset};
    alive[kept] = search;
    kept += found == sought ? 1 : 0;
  }
  foundCount_ = kept;
}

void ContextColumns::findRight(const ContextString& string, std::span<const ContextElement> context,
                               std::size_t firstElement, std::uint64_t* places) {
  bool isEntered = false;  // a bracket of the context has entered the branch whose end is sought
  for (std::size_t i = 0; i < context.size() && foundCount_ > 0; ++i) {
    const ContextElement& element = context[i];
    const bool isBranchEnd = element.kind == ContextElement::Kind::SkipToBranchEnd;
    const bool entersBranch = element.kind == ContextElement::Kind::OpenBranch;
    if (isBranchEnd && isEntered) {
      // a `]` behind it is that bracket
      const bool isClosed = i + 1 < context.size() && context[i + 1].kind == ContextElement::Kind::CloseBranch;
      moveToBranchEnds(string, places + firstElement + i, isClosed ? 1 : 0);
      i += isClosed ? 1 : 0;
      isEntered = isEntered && !isClosed;
      continue;
    }
    const Move* const moves = (isBranchEnd ? atBranchEnd_ : entersBranch ? atBranch_ : atModule_).data();
    const ModuleTypeId sought = isBranchEnd ? core::kNoModuleType : element.module.type;
    findRightOf(string, moves, sought, places + firstElement + i);
    if (!isBranchEnd && (sought == program_->openBranch || sought == program_->closeBranch)) {
      isEntered = entersBranch && areBracketsSeen_;
    }
  }
}

void ContextColumns::moveToBranchEnds(const ContextString& string, std::uint64_t* places, std::uint64_t step) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < foundCount_; ++i) {
    const std::uint32_t search = found_[i];
    // a bracket without partner has no end
    const StringIndex::Link link = string.index->link(branches_[search]);
    const std::uint64_t offset = insides_[search] + link.parameterCount;
    places[search * rowSize_] = offset;
    move(search, link.partner + step, offset);
    found_[kept] = search;
    kept += link.partner != StringIndex::kNone ? 1 : 0;
  }
  foundCount_ = kept;
}

void ContextColumns::findRightOf(const ContextString& string, const Move* moves, ModuleTypeId sought,
                                 std::uint64_t* places) {
  if (sought == program_->openBranch) {
    rules_->isRing() ? findRightOf<true, true>(string, moves, sought, places)
                     : findRightOf<false, true>(string, moves, sought, places);
  } else {
    rules_->isRing() ? findRightOf<true, false>(string, moves, sought, places)
                     : findRightOf<false, false>(string, moves, sought, places);
  }
}

template <bool kIsRing, bool kNotesBranches>
void ContextColumns::findRightOf(const ContextString& string, const Move* moves, ModuleTypeId sought,
                                 std::uint64_t* places) {
  const ModuleTypeId* const types = string.types;
  const std::uint16_t* const arity = program_->arity.data();
  const std::uint64_t size = string.size;
  // the end of a branch is any module that stops; it is reached, not passed
  const bool isBranchEnd = sought == core::kNoModuleType;
  const std::uint64_t step = isBranchEnd ? 0 : 1;
  const std::uint64_t behind = isBranchEnd ? 0 : arity[sought];
  std::uint32_t* const alive = found_.data();
  Place* const ends = places_.data();
  const std::size_t rowSize = rowSize_;
  const std::size_t count = foundCount_;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t search = alive[i];
    std::uint64_t module = ends[search].module;
    std::uint64_t offset = ends[search].offset;
    bool isFound = false;
    [[maybe_unused]] std::uint64_t remaining = size + 1;
    while (true) {
      if (module >= size) [[unlikely]] {
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
        isFound = isBranchEnd | (type == sought);
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
    places[search * rowSize] = offset;
    ends[search] = {module + step, offset + behind};
    if constexpr (kNotesBranches) {
      branches_[search] = module;
      insides_[search] = offset + behind;
    }
    alive[kept] = search;
    kept += isFound ? 1 : 0;
  }
  foundCount_ = kept;
}

}  // namespace espalier::derivation

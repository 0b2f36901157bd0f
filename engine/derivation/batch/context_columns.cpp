#include "engine/derivation/batch/context_columns.h"

#include "engine/derivation/matching/context_walk.h"

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
      insides_(laneCount) {}

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
  const LeftWalk<kIsRing> walk(*program_, *rules_, string);
  std::uint32_t* const alive = found_.data();
  SearchShortcuts::Place* const ends = places_.data();
  const std::size_t rowSize = rowSize_;
  const std::size_t count = foundCount_;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t search = alive[i];
    SearchShortcuts::Place place = ends[search];
    const ModuleTypeId found = walk.to(place);
    places[search * rowSize] = place.offset;
    ends[search] = place;
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
    const SearchKind kind = searchKind(element.kind);
    const bool isBranchEnd = kind == SearchKind::RightBranchEnd;
    if (isBranchEnd && isEntered) {
      // a `]` behind it is that bracket
      const bool isClosed = i + 1 < context.size() && context[i + 1].kind == ContextElement::Kind::CloseBranch;
      moveToBranchEnds(string, places + firstElement + i, isClosed ? 1 : 0);
      i += isClosed ? 1 : 0;
      isEntered = isEntered && !isClosed;
      continue;
    }
    const ModuleTypeId sought = isBranchEnd ? program_->closeBranch : element.module.type;
    findRightOf(string, kind, sought, places + firstElement + i);
    if (!isBranchEnd && (sought == program_->openBranch || sought == program_->closeBranch)) {
      isEntered = kind == SearchKind::RightBranch && areBracketsSeen_;
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

void ContextColumns::findRightOf(const ContextString& string, SearchKind kind, ModuleTypeId sought,
                                 std::uint64_t* places) {
  if (sought == program_->openBranch) {
    rules_->isRing() ? findRightOf<true, true>(string, kind, sought, places)
                     : findRightOf<false, true>(string, kind, sought, places);
  } else {
    rules_->isRing() ? findRightOf<true, false>(string, kind, sought, places)
                     : findRightOf<false, false>(string, kind, sought, places);
  }
}

template <bool kIsRing, bool kNotesBranches>
void ContextColumns::findRightOf(const ContextString& string, SearchKind kind, ModuleTypeId sought,
                                 std::uint64_t* places) {
  // the end of a branch is reached, not passed
  const bool isBranchEnd = kind == SearchKind::RightBranchEnd;
  const std::uint64_t step = isBranchEnd ? 0 : 1;
  const std::uint64_t behind = isBranchEnd ? 0 : program_->arity[sought];
  const RightWalk<kIsRing> walk(*program_, *rules_, kind, string);
  std::uint32_t* const alive = found_.data();
  SearchShortcuts::Place* const ends = places_.data();
  const std::size_t rowSize = rowSize_;
  const std::size_t count = foundCount_;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t search = alive[i];
    SearchShortcuts::Place place = ends[search];
    const ModuleTypeId found = walk.to(place);
    places[search * rowSize] = place.offset;
    ends[search] = {place.module + step, place.offset + behind};
    if constexpr (kNotesBranches) {
      branches_[search] = place.module;
      insides_[search] = place.offset + behind;
    }
    alive[kept] = search;
    kept += found == sought ? 1 : 0;
  }
  foundCount_ = kept;
}

}  // namespace espalier::derivation

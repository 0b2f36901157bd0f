#include "engine/derivation/matching/context_matcher.h"

#include "engine/derivation/matching/context_walk.h"

namespace espalier::derivation {
namespace {

using language::ContextElement;

/// Binds the parameters of a module that matches to a frame.
void bind(const language::Program& program, const ContextString& string, const language::FormalModule& formal,
          std::uint64_t offset, double* frame) {
  const std::size_t arity = program.arity[formal.type];
  for (std::size_t i = 0; i < arity; ++i) {
    frame[formal.firstSlot + i] = string.parameters[offset + i];
  }
}

/// Whether a search has found the sought type. Adds an entry to `looks`, when searches are recorded. `found` as from
/// LeftWalk::to.
template <bool kIsRecorded>
bool look(std::vector<ContextLook>* looks, core::ModuleTypeId sought, core::ModuleTypeId found,
          const language::Program& program, const ContextString& string, const SearchShortcuts::Place& place) {
  if constexpr (kIsRecorded) {
    using Result = ContextLook::Result;
    ContextLook& entry = looks->emplace_back();
    if (found != core::kNoModuleType) {
      entry.result = found == sought ? Result::Matched : Result::OtherModule;
      entry.module = place.module;
      entry.type = found;
      const double* const parameters = string.parameters + place.offset;
      entry.parameters.assign(parameters, parameters + program.arity[found]);
    } else {
      const core::ModuleTypeId type = place.module < string.size ? string.types[place.module] : core::kNoModuleType;
      const bool isBracket = type == program.openBranch || type == program.closeBranch;
      const bool isLone = isBracket && string.index->link(place.module).partner == StringIndex::kNone;
      entry.result = isLone ? Result::LoneBracket : Result::StringEnd;
    }
  }
  return found == sought;
}

template <bool kIsRing, bool kIsRecorded>
bool searchLeft(const language::Program& program, const ContextRules& rules, const ContextString& string,
                std::span<const ContextElement> context, std::uint64_t module, std::uint64_t offset, double* frame,
                std::vector<ContextLook>* looks) {
  const LeftWalk<kIsRing> walk(program, rules, string);
  SearchShortcuts::Place place{module, offset};
  for (const ContextElement& element : context) {
    if (element.kind != ContextElement::Kind::Module) {
      return false;
    }
    const core::ModuleTypeId type = walk.to(place);
    if (!look<kIsRecorded>(looks, element.module.type, type, program, string, place)) {
      return false;
    }
    bind(program, string, element.module, place.offset, frame);
  }
  return true;
}

template <bool kIsRing, bool kIsRecorded>
bool searchRight(const language::Program& program, const ContextRules& rules, const ContextString& string,
                 std::span<const ContextElement> context, std::uint64_t module, std::uint64_t offset, double* frame,
                 std::vector<ContextLook>* looks) {
  SearchShortcuts::Place place{module, offset};
  // the branch that the context has entered last, when brackets alone end it
  const bool areBracketsSeen =
      !kIsRing && !rules.isIgnored(program.openBranch) && !rules.isIgnored(program.closeBranch);
  std::uint64_t entered = string.size;  // its `[`; the size of the string: none
  std::uint64_t enteredOffset = 0;      // behind the `[`
  for (const ContextElement& element : context) {
    const SearchKind kind = searchKind(element.kind);
    const bool isBranchEnd = kind == SearchKind::RightBranchEnd;
    if (isBranchEnd && entered != string.size) {
      const StringIndex::Link link = string.index->link(entered);
      if (link.partner != StringIndex::kNone) {
        place = {link.partner, enteredOffset + link.parameterCount};
      }
    }
    const core::ModuleTypeId type = RightWalk<kIsRing>(program, rules, kind, string).to(place);
    const core::ModuleTypeId sought = isBranchEnd ? program.closeBranch : element.module.type;
    if (!look<kIsRecorded>(looks, sought, type, program, string, place)) {
      return false;
    }
    if (isBranchEnd) {
      continue;
    }
    bind(program, string, element.module, place.offset, frame);
    const std::uint64_t behind = place.offset + program.arity[type];
    if (type == program.openBranch || type == program.closeBranch) {
      entered = kind == SearchKind::RightBranch && areBracketsSeen ? place.module : string.size;
      enteredOffset = behind;
    }
    place = {place.module + 1, behind};
  }
  return true;
}

}  // namespace

ContextRules::ContextRules(const language::Program& program, const language::LSystem& system)
    : number_(static_cast<std::size_t>(&system - program.systems.data())), isRing_(system.isRing) {
  for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
    const auto type = static_cast<core::ModuleTypeId>(i);
    const core::SymbolId symbol = program.symbolOf[i];
    const bool isIgnored = symbol < system.isIgnored.size() && system.isIgnored[symbol];
    const bool isOpen = type == program.openBranch;
    const bool isClose = type == program.closeBranch;
    const auto set = [&](SearchKind kind, Move move) { moves_[static_cast<std::size_t>(kind)].push_back(move); };
    // to the left, a branch that ends here is passed as a whole, and a `[` leads into the mother axis
    set(SearchKind::Left, isClose ? Move::Leave : isIgnored || isOpen ? Move::Pass : Move::Stop);
    // a branch is passed as a whole, unless its bracket is ignored
    set(SearchKind::Right, isIgnored ? Move::Pass : isOpen ? Move::Leave : Move::Stop);
    set(SearchKind::RightBranch, isIgnored ? Move::Pass : Move::Stop);
    // brackets alone decide where the branch ends
    set(SearchKind::RightBranchEnd, isClose ? Move::Stop : isOpen ? Move::Leave : Move::Pass);
  }
}

SearchKind searchKind(ContextElement::Kind kind) {
  switch (kind) {
    case ContextElement::Kind::OpenBranch:
      return SearchKind::RightBranch;
    case ContextElement::Kind::SkipToBranchEnd:
      return SearchKind::RightBranchEnd;
    default:
      return SearchKind::Right;
  }
}

bool matchesLeft(const language::Program& program, const ContextRules& rules, const ContextString& string,
                 std::span<const ContextElement> context, std::uint64_t module, std::uint64_t offset, double* frame,
                 std::vector<ContextLook>* looks) {
  if (looks != nullptr) {
    return rules.isRing() ? searchLeft<true, true>(program, rules, string, context, module, offset, frame, looks)
                          : searchLeft<false, true>(program, rules, string, context, module, offset, frame, looks);
  }
  return rules.isRing() ? searchLeft<true, false>(program, rules, string, context, module, offset, frame, looks)
                        : searchLeft<false, false>(program, rules, string, context, module, offset, frame, looks);
}

bool matchesRight(const language::Program& program, const ContextRules& rules, const ContextString& string,
                  std::span<const ContextElement> context, std::uint64_t module, std::uint64_t offset, double* frame,
                  std::vector<ContextLook>* looks) {
  if (looks != nullptr) {
    return rules.isRing() ? searchRight<true, true>(program, rules, string, context, module, offset, frame, looks)
                          : searchRight<false, true>(program, rules, string, context, module, offset, frame, looks);
  }
  return rules.isRing() ? searchRight<true, false>(program, rules, string, context, module, offset, frame, looks)
                        : searchRight<false, false>(program, rules, string, context, module, offset, frame, looks);
}

}  // namespace espalier::derivation

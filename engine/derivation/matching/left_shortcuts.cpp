#include "engine/derivation/matching/left_shortcuts.h"

#include "engine/derivation/matching/context_matcher.h"

namespace espalier::derivation {
namespace {

/// Moves `place` from one `[` to the next that a search to the left reaches. False when it reaches none; `place` is
/// then the end of the search.
bool moveToNextOpen(const language::Program& program, const ContextRules& rules, const ContextString& string,
                    LeftShortcuts::Place& place) {
  while (place.module > 0) {
    const std::uint64_t before = place.module - 1;
    const core::ModuleTypeId type = string.types[before];
    if (type == program.closeBranch) {
      const StringIndex::Link link = string.index->link(before);
      if (link.partner == StringIndex::kNone) {
        return false;
      }
      place = {link.partner, place.offset - program.arity[type] - link.parameterCount};
      return true;
    }
    if (type != program.openBranch && !rules.isIgnored(type)) {
      return false;
    }
    place = {before, place.offset - program.arity[type]};
    if (type == program.openBranch) {
      return true;
    }
  }
  return false;
}

}  // namespace

LeftShortcuts::Place LeftShortcuts::follow(const language::Program& program, const ContextRules& rules,
                                           const ContextString& string, Place place) {
  passed_.clear();
  do {
    const auto known = ends_.find(place.module);
    if (known != ends_.end()) {
      place = known->second;
      break;
    }
    passed_.push_back(place.module);
  } while (moveToNextOpen(program, rules, string, place));
  for (const std::uint64_t module : passed_) {
    ends_.emplace(module, place);
  }
  return place;
}

}  // namespace espalier::derivation

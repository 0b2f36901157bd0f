#include "engine/derivation/matching/search_shortcuts.h"

#include <limits>
#include <utility>

#include "engine/derivation/matching/context_matcher.h"

namespace espalier::derivation {
namespace {

constexpr SearchShortcuts::Place kUnknown{std::numeric_limits<std::uint64_t>::max(), 0};

/// Moves `place` as a search to the left goes on from there. False when it goes no further in this direction.
bool moveLeft(const language::Program& program, const Move* moves, const ContextString& string,
              SearchShortcuts::Place& place) {
  if (place.module == 0) {
    return false;
  }
  const std::uint64_t before = place.module - 1;
  const core::ModuleTypeId type = string.types[before];
  if (moves[type] == Move::Stop) {
    return false;
  }
  SearchShortcuts::Place next{before, place.offset - program.arity[type]};
  if (moves[type] == Move::Leave) {
    const StringIndex::Link link = string.index->link(before);
    if (link.partner == StringIndex::kNone) {
      return false;
    }
    next = {link.partner, next.offset - link.parameterCount};
  }
  place = next;
  return true;
}

/// The same to the right.
bool moveRight(const language::Program& program, const Move* moves, const ContextString& string,
               SearchShortcuts::Place& place) {
  if (place.module >= string.size) {
    return false;
  }
  const core::ModuleTypeId type = string.types[place.module];
  if (moves[type] == Move::Stop) {
    return false;
  }
  if (moves[type] == Move::Pass) {
    place = {place.module + 1, place.offset + program.arity[type]};
    return true;
  }
  const StringIndex::Link link = string.index->link(place.module);
  if (link.partner == StringIndex::kNone) {
    return false;
  }
  place = {link.partner + 1, place.offset + link.parameterCount};
  return true;
}

}  // namespace

void SearchShortcuts::clear() {
  for (Ends& ends : ends_) {
    for (const std::uint64_t block : ends.used) {
      spares_.push_back(std::move(ends.blocks[block]));
    }
    ends.used.clear();
  }
}

SearchShortcuts::Place& SearchShortcuts::endFrom(Ends& ends, std::uint64_t module) {
  const std::uint64_t number = module / kBlockModules;
  if (ends.blocks.size() <= number) {
    ends.blocks.resize(number + 1);
  }
  std::unique_ptr<Block>& block = ends.blocks[number];
  if (block == nullptr) {
    if (spares_.empty()) {
      spares_.push_back(std::make_unique<Block>());
    }
    block = std::move(spares_.back());
    spares_.pop_back();
    block->fill(kUnknown);
    ends.used.push_back(number);
  }
  return (*block)[module % kBlockModules / kMarkDistance];
}

SearchShortcuts::Place SearchShortcuts::follow(const language::Program& program, const ContextRules& rules,
                                               SearchKind kind, const ContextString& string, Place place) {
  const std::size_t number = rules.number() * kSearchKinds + static_cast<std::size_t>(kind);
  if (ends_.size() <= number) {
    ends_.resize(number + 1);
  }
  const Move* const moves = rules.moves(kind);
  const auto move = kind == SearchKind::Left ? moveLeft : moveRight;
  passed_.clear();
  do {
    if (isMark(place.module)) {
      Place& end = endFrom(ends_[number], place.module);
      if (end.module != kUnknown.module) {
        place = end;
        break;
      }
      passed_.push_back(&end);
    }
  } while (move(program, moves, string, place));
  for (Place* const end : passed_) {
    *end = place;
  }
  return place;
}

}  // namespace espalier::derivation

#pragma once

#include <cstdint>

#include "engine/derivation/matching/context_matcher.h"

namespace espalier::derivation {

/// Walks of searches to the left in one string: the inner loops of all contexts. Inline, and with copies of what they
/// read, so that many searches in a row keep these in registers.
template <bool kIsRing>
class LeftWalk {
 public:
  /// All must outlive the object.
  LeftWalk(const language::Program& program, const ContextRules& rules, const ContextString& string)
      : program_(program),
        rules_(rules),
        string_(string),
        types_(string.types),
        arity_(program.arity.data()),
        moves_(rules.moves(SearchKind::Left)) {}

  /// Takes a search from `place` to the module at which it stops. Returns the module's type, or kNoModuleType at the
  /// end of the string or at a `]` without partner.
  [[gnu::always_inline]] core::ModuleTypeId to(SearchShortcuts::Place& place) const {
    std::uint64_t module = place.module;
    std::uint64_t offset = place.offset;
    core::ModuleTypeId found = core::kNoModuleType;
    [[maybe_unused]] bool hasWrapped = false;
    std::uint32_t passed = 0;
    while (true) {
      if (module == 0) {
        // a search that comes to the end of a ring twice would never stop
        if (!kIsRing || !string_.canWrap || hasWrapped) {
          break;
        }
        hasWrapped = true;
        module = string_.size;
        offset = string_.parameterCount;
        continue;
      }
      --module;
      const core::ModuleTypeId type = types_[module];
      const Move move = moves_[type];
      offset -= arity_[type];
      if (move == Move::Stop) [[likely]] {
        found = type;
        break;
      }
      if (move == Move::Leave) {
        const StringIndex::Link link = string_.index->link(module);
        if (link.partner == StringIndex::kNone) {
          break;
        }
        module = link.partner;
        offset -= link.parameterCount;
      }
      // all searches together walk over a module once
      if (++passed > SearchShortcuts::kNearModules && SearchShortcuts::isMark(module)) [[unlikely]] {
        const auto end = string_.shortcuts->follow(program_, rules_, SearchKind::Left, string_, {module, offset});
        module = end.module;
        offset = end.offset;
        passed = 0;
      }
    }
    place = {module, offset};
    return found;
  }

 private:
  const language::Program& program_;
  const ContextRules& rules_;
  const ContextString& string_;
  const core::ModuleTypeId* types_;
  const std::uint16_t* arity_;
  const Move* moves_;
};

/// The same to the right, for one kind of search.
template <bool kIsRing>
class RightWalk {
 public:
  RightWalk(const language::Program& program, const ContextRules& rules, SearchKind kind, const ContextString& string)
      : program_(program),
        rules_(rules),
        kind_(kind),
        string_(string),
        size_(string.size),
        types_(string.types),
        arity_(program.arity.data()),
        moves_(rules.moves(kind)) {}

  /// As LeftWalk::to. The search begins with the module at `place`.
  [[gnu::always_inline]] core::ModuleTypeId to(SearchShortcuts::Place& place) const {
    std::uint64_t module = place.module;
    std::uint64_t offset = place.offset;
    core::ModuleTypeId found = core::kNoModuleType;
    [[maybe_unused]] bool hasWrapped = false;
    std::uint32_t passed = 0;
    while (true) {
      if (module >= size_) [[unlikely]] {
        if (!kIsRing || hasWrapped) {
          break;
        }
        hasWrapped = true;
        module = 0;
        offset = 0;
        continue;
      }
      const core::ModuleTypeId type = types_[module];
      const Move move = moves_[type];
      if (move == Move::Stop) [[likely]] {
        found = type;
        break;
      }
      if (move == Move::Pass) {
        offset += arity_[type];
        ++module;
      } else {
        const StringIndex::Link link = string_.index->link(module);
        if (link.partner == StringIndex::kNone) {
          break;
        }
        module = link.partner + 1;
        offset += link.parameterCount;
      }
      if (++passed > SearchShortcuts::kNearModules && SearchShortcuts::isMark(module)) [[unlikely]] {
        const auto end = string_.shortcuts->follow(program_, rules_, kind_, string_, {module, offset});
        module = end.module;
        offset = end.offset;
        passed = 0;
      }
    }
    place = {module, offset};
    return found;
  }

 private:
  const language::Program& program_;
  const ContextRules& rules_;
  SearchKind kind_;
  const ContextString& string_;
  std::uint64_t size_;
  const core::ModuleTypeId* types_;
  const std::uint16_t* arity_;
  const Move* moves_;
};

}  // namespace espalier::derivation

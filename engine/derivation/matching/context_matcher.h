#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/derivation/matching/search_shortcuts.h"
#include "engine/derivation/state/module_string.h"
#include "engine/derivation/state/string_index.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The kinds of context searches. They differ in the modules that they pass.
enum class SearchKind : std::uint8_t {
  Left,
  Right,           // for a module or a `]`
  RightBranch,     // for a `[`
  RightBranchEnd,  // for the end of the branch (`=`)
};
inline constexpr std::size_t kSearchKinds = 4;

/// The move of a search at a module.
enum class Move : std::uint8_t {
  Stop,   // the sought module must be this one
  Pass,   // on to the next module
  Leave,  // on behind the branch whose bracket this is; to the left: on to its `[`
};

/// The rules of an L-system for context searches: the ignored module types, and whether its string is a ring.
class ContextRules {
 public:
  /// `system` is one of `program`.
  ContextRules(const language::Program& program, const language::LSystem& system);
  [[nodiscard]] bool isIgnored(core::ModuleTypeId type) const {
    return moves(SearchKind::RightBranch)[type] == Move::Pass;
  }
  [[nodiscard]] bool isRing() const { return isRing_; }
  /// The number of the L-system.
  [[nodiscard]] std::size_t number() const { return number_; }
  /// The moves of a search, by module type.
  [[nodiscard]] const Move* moves(SearchKind kind) const { return moves_[static_cast<std::size_t>(kind)].data(); }

 private:
  std::array<std::vector<Move>, kSearchKinds> moves_;
  std::size_t number_ = 0;
  bool isRing_ = false;
};

/// The string in which a search looks for neighbours. A view: string and index must stay unchanged while it is used.
struct ContextString {
  const core::ModuleTypeId* types = nullptr;
  const double* parameters = nullptr;
  std::uint64_t size = 0;
  std::uint64_t parameterCount = 0;
  const StringIndex* index = nullptr;
  bool canWrap = true;                   // false: no search continues at the other end, even in a ring
  SearchShortcuts* shortcuts = nullptr;  // for this string
};

/// The search for an element of a right context.
[[nodiscard]] SearchKind searchKind(language::ContextElement::Kind kind);

/// The result of a search for one element of a context.
struct ContextLook {
  enum class Result : std::uint8_t { Matched, OtherModule, StringEnd, LoneBracket };
  Result result = Result::Matched;
  std::uint64_t module = 0;  // of the searched string; Matched and OtherModule
  core::ModuleTypeId type = core::kNoModuleType;
  std::vector<double> parameters;
};

/// Whether the modules left of module `module` (its parameters begin at `offset`) match a left context, given nearest
/// first. Binds the parameters that it finds to `frame`. The search skips branches that end on the way and ignored
/// symbols; a `[` leads into the mother axis (docs/language.md, 1.6). `looks`, when given, gets an entry for each
/// element up to the first that fails. O(1) on average over all searches in the string.
[[nodiscard]] bool matchesLeft(const language::Program& program, const ContextRules& rules, const ContextString& string,
                               std::span<const language::ContextElement> context, std::uint64_t module,
                               std::uint64_t offset, double* frame, std::vector<ContextLook>* looks = nullptr);

/// The same to the right, from module `module` on. The search skips ignored symbols first, then a branch, unless the
/// context names its `[`. A `]` is a symbol like any other.
[[nodiscard]] bool matchesRight(const language::Program& program, const ContextRules& rules,
                                const ContextString& string, std::span<const language::ContextElement> context,
                                std::uint64_t module, std::uint64_t offset, double* frame,
                                std::vector<ContextLook>* looks = nullptr);

}  // namespace espalier::derivation

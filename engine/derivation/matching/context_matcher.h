#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/derivation/matching/left_shortcuts.h"
#include "engine/derivation/state/module_string.h"
#include "engine/derivation/state/string_index.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The rules of an L-system for context searches: the ignored module types, and whether its string is a ring.
class ContextRules {
 public:
  ContextRules(const language::Program& program, const language::LSystem& system);
  [[nodiscard]] bool isIgnored(core::ModuleTypeId type) const { return (traits_[type] & kIgnored) != 0; }
  [[nodiscard]] bool isRing() const { return isRing_; }

  /// The properties of a module type that searches test, as bits. 0: every search stops at such a module.
  static constexpr std::uint8_t kIgnored = 1;
  static constexpr std::uint8_t kOpenBranch = 2;
  static constexpr std::uint8_t kCloseBranch = 4;
  [[nodiscard]] const std::uint8_t* traits() const { return traits_.data(); }

 private:
  std::vector<std::uint8_t> traits_;  // by module type (moduleTypeCount)
  bool isRing_ = false;
};

/// The string in which a search looks for neighbours. A view: string and index must stay unchanged while it is used.
struct ContextString {
  const core::ModuleTypeId* types = nullptr;
  const double* parameters = nullptr;
  std::uint64_t size = 0;
  std::uint64_t parameterCount = 0;
  const StringIndex* index = nullptr;
  bool canWrap = true;                 // false: no search continues at the other end, even in a ring
  LeftShortcuts* shortcuts = nullptr;  // for this string and the rules of the search; null: long searches walk
};

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
/// element up to the first that fails. O(modules passed), or O(1) on average with shortcuts.
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

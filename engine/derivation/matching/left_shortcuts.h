#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "engine/core/identifiers.h"

namespace espalier::language {
struct Program;
}

namespace espalier::derivation {

class ContextRules;
struct ContextString;

/// Remembers where long searches to the left ended, for one string and one set of rules. Without it, every module
/// behind a node with many branches walks over all of these branches; with it, all searches together walk over a
/// bracket once. One thread at a time.
class LeftShortcuts {
 public:
  /// A search that has passed more modules than this calls follow.
  static constexpr std::uint32_t kNearModules = 16;

  /// A place in the string: a module and where its parameters begin.
  struct Place {
    std::uint64_t module = 0;
    std::uint64_t offset = 0;
  };

  /// Forgets everything, for another string or other rules.
  void clear() {
    if (!ends_.empty()) {
      ends_.clear();
    }
  }
  /// The place that a search reaches from the `[` at `place` when it passes branches and ignored symbols. Before that
  /// place stands a module that the search does not pass, a bracket without partner, or nothing. O(1) on average over
  /// all calls.
  [[nodiscard]] Place follow(const language::Program& program, const ContextRules& rules, const ContextString& string,
                             Place place);

 private:
  std::unordered_map<std::uint64_t, Place> ends_;  // by module: a `[`
  std::vector<std::uint64_t> passed_;              // by the present search
};

}  // namespace espalier::derivation

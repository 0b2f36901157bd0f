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

/// Where long searches to the left ended, for one string and one set of rules. A node with many branches, or many
/// branches inside each other without a module that counts between them, would have each module behind it walk over all
/// of them; with this every bracket is walked over once. One thread at a time.
class LeftShortcuts {
 public:
  /// A search that passes more modules than this asks here.
  static constexpr std::uint32_t kNearModules = 16;

  /// A place in the string: a module and where its parameters begin.
  struct Place {
    std::uint64_t module = 0;
    std::uint64_t offset = 0;
  };

  /// Forgets everything: another string, or other rules.
  void clear() {
    if (!ends_.empty()) {
      ends_.clear();
    }
  }
  /// The place that a search which stands at the `[` at `place` comes to when it passes branches and ignored symbols:
  /// before it stands a module that it does not pass, a bracket without partner, or nothing. O(1) on average over all
  /// calls.
  [[nodiscard]] Place follow(const language::Program& program, const ContextRules& rules, const ContextString& string,
                             Place place);

 private:
  std::unordered_map<std::uint64_t, Place> ends_;  // by module: a `[`
  std::vector<std::uint64_t> passed_;              // by the search that is on
};

}  // namespace espalier::derivation

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/identifiers.h"

namespace espalier::language {
struct Program;
}

namespace espalier::derivation {

class ContextRules;
struct ContextString;
enum class SearchKind : std::uint8_t;

/// Remembers where long context searches ended, in one string. Without it, every module of a row of ignored modules,
/// and every module behind a node with many branches, walks over all that lies before it; with it, all searches
/// together walk over a module once. One thread at a time. Takes 4 bytes a module where searches were long.
class SearchShortcuts {
 public:
  /// A search that has passed more modules than this calls follow at the next mark.
  static constexpr std::uint32_t kNearModules = 12;

  /// A place in the string: a module and where its parameters begin.
  struct Place {
    std::uint64_t module = 0;
    std::uint64_t offset = 0;
  };

  /// Whether ends are remembered for a search that has come to `module`: one of every four neighbours. Which of them
  /// changes along the string, so that no regular distance between branches leaps over all marks.
  [[nodiscard]] static bool isMark(std::uint64_t module) {
    return ((module ^ (module >> 2) ^ (module >> 5) ^ (module >> 9)) % kMarkDistance) == 0;
  }

  /// Forgets everything, for another string. O(modules at which ends are remembered).
  void clear();
  /// The place that a search reaches from `place`, a mark. At that place (to the left: before it) stands a module that
  /// the search does not pass, a bracket without partner, or nothing. O(1) on average over all calls.
  [[nodiscard]] Place follow(const language::Program& program, const ContextRules& rules, SearchKind kind,
                             const ContextString& string, Place place);

 private:
  static constexpr std::uint64_t kMarkDistance = 4;
  static constexpr std::uint64_t kBlockModules = 1024;
  /// The ends from the marks of some neighbouring modules.
  using Block = std::array<Place, kBlockModules / kMarkDistance>;
  /// The ends of one kind of search, by L-system.
  struct Ends {
    std::vector<std::unique_ptr<Block>> blocks;  // null: none of its marks is known
    std::vector<std::uint64_t> used;             // the numbers of the others
  };
  [[nodiscard]] Place& endFrom(Ends& ends, std::uint64_t module);

  std::vector<Ends> ends_;                      // by the number of the rules and the kind of the search
  std::vector<std::unique_ptr<Block>> spares_;  // blocks for use again
  std::vector<Place*> passed_;                  // the ends from the marks that the present search has passed
};

}  // namespace espalier::derivation

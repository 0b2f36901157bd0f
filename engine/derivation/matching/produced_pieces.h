#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/derivation/matching/context_matcher.h"
#include "engine/derivation/state/module_string.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// A string that is produced from right to left, as pieces in the order of production: the piece of the last old module
/// comes first. The modules of a piece have the order of the new string.
class ProducedPieces {
 public:
  void clear();

  /// Begins the piece of the next old module to the left. Modules appended to modules() from now on belong to it.
  void begin();
  [[nodiscard]] ModuleString& modules() { return modules_; }

  /// Empties the `count` pieces before the last piece, because a cut removes them. The last piece must be empty.
  void dropBefore(std::uint64_t count);

  /// The modules of a piece, which are counted from the right.
  [[nodiscard]] std::uint64_t sizeOf(std::size_t piece) const { return endModule(piece) - pieces_[piece].firstModule; }

  /// Appends the whole new string to `string`, left to right. O(modules).
  void appendTo(ModuleString& string) const;

  /// Whether the new string right of the last piece matches a right context, given nearest first, by the search rules
  /// of matchesRight, without ring. O(modules passed).
  [[nodiscard]] bool matchesRight(const language::Program& program, const ContextRules& rules,
                                  std::span<const language::ContextElement> context, double* frame) const;

 private:
  struct Piece {
    std::uint64_t firstModule = 0;
    std::uint64_t firstParameter = 0;
  };
  struct Cursor {
    std::size_t piece = 0;  // index + 1; 0: behind the last module
    std::uint64_t module = 0;
    std::uint64_t offset = 0;
  };
  [[nodiscard]] std::uint64_t endModule(std::size_t piece) const;
  void settle(Cursor& cursor) const;
  void advance(const language::Program& program, Cursor& cursor) const;
  [[nodiscard]] bool skipBranch(const language::Program& program, Cursor& cursor) const;

  ModuleString modules_;
  std::vector<Piece> pieces_;  // by old module, from the right (rewritten module count)
};

}  // namespace espalier::derivation

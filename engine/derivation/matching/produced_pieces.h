#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "engine/derivation/matching/context_matcher.h"
#include "engine/derivation/state/module_string.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// A string that is produced from right to left, as pieces in the order of production: the piece of the last old module
/// comes first. The modules of a piece have the order of the new string.
class ProducedPieces {
 public:
  /// `program` must outlive the object.
  explicit ProducedPieces(const language::Program& program) : program_(&program) {}

  void clear();

  /// Begins the piece of the next old module to the left. Modules appended to modules() from now on belong to it.
  void begin();
  [[nodiscard]] ModuleString& modules() { return modules_; }

  /// Empties the pieces of the `count` old modules before the last one, because a cut removes them. The last piece must
  /// be empty, and the pieces of an earlier cut are emptied together or not at all. O(1) on average.
  void dropBefore(std::uint64_t count);

  /// The pieces, counted from the right, and what each has become of how many old modules.
  [[nodiscard]] std::size_t count() const { return pieces_.size(); }
  [[nodiscard]] std::uint64_t oldModulesOf(std::size_t piece) const { return pieces_[piece].oldModules; }
  [[nodiscard]] std::uint64_t sizeOf(std::size_t piece) const { return endModule(piece) - pieces_[piece].firstModule; }

  /// Appends the whole new string to `string`, left to right. O(modules).
  void appendTo(ModuleString& string) const;

  /// Whether the new string right of the last piece matches a right context, given nearest first, by the search rules
  /// of derivation::matchesRight, without ring. O(1) on average over all searches of a step.
  [[nodiscard]] bool matchesRight(const ContextRules& rules, std::span<const language::ContextElement> context,
                                  double* frame);

 private:
  /// A place in the new string.
  struct Cursor {
    std::size_t piece = 0;  // index + 1; 0: behind the last module
    std::uint64_t module = 0;
    std::uint64_t offset = 0;
  };
  struct Piece {
    std::uint64_t firstModule = 0;
    std::uint64_t firstParameter = 0;
    std::size_t behind = 0;         // index + 1 of the nearest piece to the right that has modules; 0: none
    std::size_t enclosingEnds = 0;  // index + 1 of the innermost of ends_ around the piece's right end; 0: none
    std::uint64_t number = 0;       // that no other piece of the step has, dropped ones included
    std::uint64_t oldModules = 1;   // more: they were dropped together
  };
  /// The end of a branch whose `[` is not known yet.
  struct BranchEnd {
    Cursor behind;            // the place behind the `]`
    std::size_t outside = 0;  // the next one further out, as in Piece::enclosingEnds
  };
  [[nodiscard]] std::uint64_t endModule(std::size_t piece) const;
  [[nodiscard]] Cursor beginOf(std::size_t behind) const;
  /// The same place, or the beginning of the next piece when it is the end of a piece.
  [[nodiscard]] Cursor settled(Cursor cursor) const;
  /// Finds where the branches of the last piece end. Returns the `enclosingEnds` for the next piece to the left.
  [[nodiscard]] std::size_t linkLast();
  /// Moves a search on. False when it goes no further.
  [[nodiscard]] bool move(const Move* moves, Cursor& cursor) const;
  /// The place that a search reaches from `cursor`, a mark, as SearchShortcuts::follow.
  [[nodiscard]] Cursor follow(SearchKind kind, const Move* moves, Cursor cursor);
  /// The place of a cursor in its piece.
  [[nodiscard]] std::uint64_t placeIn(const Cursor& cursor) const {
    return cursor.module - pieces_[cursor.piece - 1].firstModule;
  }
  [[nodiscard]] bool isMark(const Cursor& cursor) const {
    return SearchShortcuts::isMark(cursor.piece + placeIn(cursor));
  }
  /// A number that no other module of the step has, however many are dropped.
  [[nodiscard]] std::uint64_t keyOf(const Cursor& cursor) const {
    return (pieces_[cursor.piece - 1].number << 32U) + placeIn(cursor);
  }

  const language::Program* program_;
  ModuleString modules_;
  std::uint64_t pieceNumber_ = 0;                           // of the last piece
  std::vector<Piece> pieces_;                               // from the right
  std::vector<BranchEnd> ends_;                             // in the order of production
  std::unordered_map<std::uint64_t, Cursor> branchBehind_;  // by module, a `[`: the place behind its branch
  std::array<std::unordered_map<std::uint64_t, Cursor>, kSearchKinds> shortcuts_;  // by keyOf(): ends of searches
  std::vector<std::uint64_t> passed_;                                              // keys, by the present search
};

}  // namespace espalier::derivation

#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "engine/derivation/batch/scratch.h"
#include "engine/derivation/matching/context_matcher.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Searches one context for many modules at once, with the results of matchesLeft and matchesRight. The outer loop goes
/// over the elements of the context, the inner loop over the modules whose search has not failed so far. So the kind of
/// an element is asked once, and the searches of neighbouring modules run into each other in the processor.
class ContextColumns {
 public:
  /// `program` and `rules` must outlive the object. At most `laneCount` searches at once.
  ContextColumns(const language::Program& program, const ContextRules& rules, std::size_t laneCount);

  /// Begins `count` searches; move() says where each starts. Each gets `rowSize` entries of `places`, one for each
  /// element of both contexts: where the parameters of the element's module begin.
  void begin(std::size_t count, std::size_t rowSize) {
    rowSize_ = rowSize;
    foundCount_ = count;
    std::iota(found_.begin(), found_.begin() + count, 0U);
  }
  /// The numbers of the searches that have not failed so far, in their order.
  [[nodiscard]] std::span<const std::uint32_t> found() const { return {found_.data(), foundCount_}; }
  /// A search goes on from a module, whose parameters begin at `offset`. A search to the left looks before it.
  void move(std::uint32_t search, std::uint64_t module, std::uint64_t offset) { places_[search] = {module, offset}; }

  /// Searches a context from where the searches stand. Its entries begin at element `firstElement` of each row.
  void findLeft(const ContextString& string, std::span<const language::ContextElement> context,
                std::size_t firstElement, std::uint64_t* places);
  void findRight(const ContextString& string, std::span<const language::ContextElement> context,
                 std::size_t firstElement, std::uint64_t* places);

 private:
  template <bool kIsRing>
  void findLeftOf(const ContextString& string, core::ModuleTypeId sought, std::uint64_t* places);
  /// `kNotesBranches`: the module is a `[`, whose end may be sought later.
  template <bool kIsRing, bool kNotesBranches>
  void findRightOf(const ContextString& string, SearchKind kind, core::ModuleTypeId sought, std::uint64_t* places);
  void findRightOf(const ContextString& string, SearchKind kind, core::ModuleTypeId sought, std::uint64_t* places);
  /// To the end of the branch that the context has entered, and `step` modules further.
  void moveToBranchEnds(const ContextString& string, std::uint64_t* places, std::uint64_t step);

  const language::Program* program_;
  const ContextRules* rules_;
  bool areBracketsSeen_;  // brackets alone decide where a branch ends
  std::size_t rowSize_ = 0;
  std::size_t foundCount_ = 0;              // that have not failed
  Scratch<std::uint32_t> found_;            // these
  Scratch<SearchShortcuts::Place> places_;  // by search: where it goes on
  Scratch<std::uint64_t> branches_;         // by search: the `[` that the context has entered last
  Scratch<std::uint64_t> insides_;          // by search: the parameters behind it
};

}  // namespace espalier::derivation

#pragma once

#include <cstddef>
#include <cstdint>
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
  /// The searches of a batch, one in each lane.
  struct Lanes {
    std::uint32_t* sites;     // (lanes) names of the modules, which the caller gives
    std::uint64_t* rows;      // (lanes) where the lane's entries of `places` begin
    std::uint64_t* places;    // gets the offset of the parameters of each element's module
    std::uint64_t laneCount;  // searches that have not failed: each search moves them to the front
  };

  /// `program` and `rules` must outlive the object. At most `laneCount` lanes.
  ContextColumns(const language::Program& program, const ContextRules& rules, std::size_t laneCount);

  /// Where the search of a lane begins: behind the predecessor, or at it.
  void setStart(std::size_t lane, std::uint64_t module, std::uint64_t offset) {
    modules_[lane] = module;
    offsets_[lane] = offset;
  }
  /// The contexts of all lanes, from their starts on. Entries of `places` begin at element `firstElement` of a row.
  void findLeft(const ContextString& string, std::span<const language::ContextElement> context,
                std::size_t firstElement, Lanes& lanes);
  void findRight(const ContextString& string, std::span<const language::ContextElement> context,
                 std::size_t firstElement, Lanes& lanes);

 private:
  /// What a search to the right does at a module.
  enum class Move : std::uint8_t {
    Stop,   // the element's module must be this one
    Pass,   // on to the next module
    Leave,  // on behind the branch that begins here
  };

  template <bool kIsRing>
  void findLeftOf(const ContextString& string, core::ModuleTypeId sought, std::size_t element, Lanes& lanes);
  template <bool kIsRing>
  void findRightOf(const ContextString& string, const Move* moves, core::ModuleTypeId sought, std::size_t element,
                   Lanes& lanes);
  void moveToBranchEnds(const ContextString& string, std::size_t laneCount);

  const language::Program* program_;
  const ContextRules* rules_;
  bool areBracketsSeen_;             // brackets alone decide where a branch ends
  std::vector<Move> atModule_;       // by module type: the search for a module or a `]`
  std::vector<Move> atBranch_;       // for a `[`
  std::vector<Move> atBranchEnd_;    // for the end of the branch
  Scratch<std::uint64_t> modules_;   // by lane: the module where the search goes on
  Scratch<std::uint64_t> offsets_;   // by lane: its parameters
  Scratch<std::uint64_t> branches_;  // by lane: the `[` that the context has entered last
  Scratch<std::uint64_t> insides_;   // by lane: the parameters behind it
};

}  // namespace espalier::derivation

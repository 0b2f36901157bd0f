#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/turtle/interpretation/interpreter.h"
#include "engine/turtle/interpretation/turtle_passage.h"
#include "engine/turtle/scene/scene.h"
#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

/// Records of a part of a string are numbered within the part. A number from here on names an outer record, which is
/// before the part: the outer record number `number - kOuterRecord`. Outer records are that of the part's entry, then
/// those of the branches that the part closes.
inline constexpr std::uint32_t kOuterRecord = 0x80000000;

/// The records of a stretch of a plant's string of about a hundred modules.
struct RecordStretch {
  std::uint64_t birth = 0;  // the generation of the first chain that has it
  TurtlePassage passage;
  std::vector<TurtleRecord> records;  // `module` counts from its first module; `parent` as in the passage
  std::uint64_t bytes = 0;            // of memory
};

/// Stretches one after the other. Where none of them changed, the next chain takes the whole group at once.
struct RecordGroup {
  struct Link {
    std::shared_ptr<const RecordStretch> stretch;
    std::uint32_t firstRecord = 0;  // among the group's
    std::uint32_t firstOuter = 0;   // in `outer`: its outer records
    std::uint64_t firstModule = 0;  // among the group's
  };

  std::uint64_t birth = 0;  // the generation of the first chain that has it
  TurtlePassage passage;
  std::vector<Link> links;           // at most kMostStretches
  std::vector<std::uint32_t> outer;  // records that stretches begin with, numbered as in the passage
  std::uint64_t bytes = 0;           // of memory, its stretches' included
};

/// The most stretches of a group.
inline constexpr std::size_t kMostStretches = 64;

/// The turtle records of a simulation as groups of stretches of its strings. Each chain of a simulation is made from
/// the one before and shares with it the groups and stretches that have not changed. So a chain has a group or stretch
/// of a later chain exactly when it is not older than their birth. Immutable.
struct RecordChain {
  /// Which of the Programs a plant has, and where it stands.
  struct Origin {
    std::uint32_t program = 0;
    PlantPlacement placement;
    bool operator==(const Origin&) const = default;
  };
  struct Link {
    std::shared_ptr<const RecordGroup> group;
    std::uint64_t firstModule = 0;  // in its plant's string
    std::uint32_t firstRecord = 0;  // among all records
    std::uint32_t firstOuter = 0;   // in `outer`: its outer records
  };
  /// A stretch where it is in the whole.
  struct Place {
    const RecordStretch* stretch = nullptr;
    const RecordGroup* group = nullptr;
    std::size_t link = 0;           // of `links`
    std::uint64_t firstModule = 0;  // in its plant's string
    std::uint32_t firstRecord = 0;  // among all records
    std::uint32_t firstOuter = 0;   // in the group's `outer`
  };

  std::uint64_t generation = 0;                                    // of the chains of one simulation, rising
  std::vector<std::shared_ptr<const language::Program>> programs;  // that it was made with
  std::vector<Origin> origins;                                     // by plant
  std::vector<std::size_t> firstLink{0};                           // by plant (plantCount + 1)
  std::vector<Link> links;                                         // of all plants, in order
  std::vector<std::uint32_t> outer;                                // records that groups begin with, or kNoParent
  std::uint32_t recordCount = 0;
  std::uint64_t bytes = 0;  // of memory, as if nothing were shared

  /// The stretches of links [begin, end), in order.
  [[nodiscard]] std::vector<Place> places(std::size_t begin, std::size_t end) const;
  /// A record as a stretch numbers it, as it is in the whole; kNoParent stays.
  [[nodiscard]] std::uint32_t recordOf(const Place& place, std::uint32_t number) const;
  /// The k-th outer record of a stretch, as it is in the whole.
  [[nodiscard]] std::uint32_t outerRecordOf(const Place& place, std::size_t k) const;
};

/// Whether the drawing of a module depends only on the module and on the turtle. It does without sub-L-systems and
/// `?(id,k)`, and without a homomorphism that has contexts, chance or blocks or reads a variable.
[[nodiscard]] bool isRepeatable(const language::Program& program);

}  // namespace espalier::turtle

#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/turtle/interpreter.h"
#include "engine/turtle/scene.h"
#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

/// From here on a record's number names one before the stretch: RecordChain::outer of its link, at the number less
/// kOuterRecord.
inline constexpr std::uint32_t kOuterRecord = 0x80000000;

/// A stretch of a plant's string with all that its interpretation began with and gave. Where the same modules follow
/// the same turtle again, the same comes of them, wherever they are in the string.
struct RecordStretch {
  std::vector<core::ModuleTypeId> types;  // of its modules
  std::vector<double> parameters;         // of its modules, concatenated
  TurtleState entry;                      // before it
  std::vector<TurtleState> closed;        // at the branches open before it that it closes, the innermost first
  TurtleState exit;                       // after it; records count from the stretch's first, or are outer ones
  std::vector<TurtleState> opened;        // at the branches that it leaves open, the outermost first; records as above
  std::vector<TurtleRecord> records;      // `module` counts from its first module; `parent` as the records above
  bool endsString = false;                // nothing was behind it
  std::uint64_t bytes = 0;                // of memory
};

/// The turtle records of a simulation as stretches of its strings, shared with the chains of other steps that have them
/// too. Never changes.
struct RecordChain {
  /// Which of the Programs a plant has, and where it stands.
  struct Origin {
    std::uint32_t program = 0;
    PlantPlacement placement;
    bool operator==(const Origin&) const = default;
  };
  struct Link {
    std::shared_ptr<const RecordStretch> stretch;
    std::uint64_t firstModule = 0;  // in its plant's string
    std::uint32_t firstRecord = 0;  // among all records
    std::uint32_t firstOuter = 0;   // in `outer`: the record that its entry has, then those of the branches it closes
  };

  std::vector<std::shared_ptr<const language::Program>> programs;  // that it was made with
  std::vector<Origin> origins;                                     // by plant
  std::vector<std::size_t> firstLink{0};                           // by plant (plantCount + 1)
  std::vector<Link> links;                                         // of all plants, in order
  std::vector<std::uint32_t> outer;                                // records that stretches begin with, or kNoParent
  std::uint32_t recordCount = 0;
  std::uint64_t bytes = 0;  // of memory, as if nothing were shared

  /// The records of a link, its parents and modules numbered as in the whole.
  void appendRecords(const Link& link, std::vector<TurtleRecord>& records) const;
  /// A parent as a stretch has it, as it is in the whole.
  [[nodiscard]] std::uint32_t recordOf(const Link& link, std::uint32_t number) const;
};

/// Whether what a module draws depends on the module and on the turtle alone: without homomorphism, or with one that
/// has neither contexts nor chance nor blocks and reads no variable; without sub-L-systems and `?(id,k)`.
[[nodiscard]] bool isRepeatable(const language::Program& program);

}  // namespace espalier::turtle

#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <unordered_map>
#include <vector>

#include "engine/core/buffer.h"
#include "engine/derivation/state/module_finder.h"
#include "engine/derivation/state/module_string.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Links between the brackets of a string, so that a context search skips a branch in one move. Takes eight bytes a
/// module, of which only those at brackets are touched. A map holds the few branches that are too long for eight bytes.
class StringIndex {
 public:
  static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();

  struct Link {
    std::uint64_t partner;         // index of the other bracket, or kNone when it has none
    std::uint64_t parameterCount;  // parameters of all modules between the two
  };

  /// `program` must outlive the object. The map holds branches of more than `longestShortBranch` modules or parameters
  /// (at most the default).
  explicit StringIndex(const language::Program& program,
                       std::uint64_t longestShortBranch = std::numeric_limits<std::int32_t>::max());

  /// A bracket whose partner is not known yet.
  struct Open {
    std::uint64_t module;
    std::uint64_t parameterOffset;  // of the first module inside for `[`, of the bracket itself for `]`
  };
  /// A branch that is too long for a short link.
  struct Branch {
    std::uint64_t open;
    std::uint64_t close;
    std::uint64_t parameterCount;
  };
  /// The brackets of a part of a string whose partners lie outside the part. Offsets count from the part's first
  /// parameter.
  struct OpenEnds {
    std::vector<Open> closed;   // `]` without `[` before it
    core::Buffer<Open> opened;  // `[` without `]` behind it
    std::vector<Branch> longBranches;
  };

  void clear();

  /// Makes room for the links of a string that is indexed in parts. The caller then calls linkPart for each part
  /// [first, end), on any threads at the same time, and after that joinPart in the order of the parts, with the offset
  /// of each part's parameters.
  void beginParts(std::uint64_t size);
  void linkPart(const core::ModuleTypeId* types, std::uint64_t first, std::uint64_t end, OpenEnds& ends);
  void joinPart(const OpenEnds& ends, std::uint64_t parameterOffset);

  /// Adds the modules from where the last call ended to the end of `string`. A `[` that is still open has no partner
  /// yet. O(new modules).
  void extend(const ModuleString& string);

  /// Whether the links of the indexed string, `before`, hold for the string `now` too: as many modules, brackets at the
  /// same places, and elsewhere modules with as many parameters. O(modules); a comparison of bytes where the types are
  /// equal.
  [[nodiscard]] bool isShared(std::span<const core::ModuleTypeId> before,
                              std::span<const core::ModuleTypeId> now) const;

  /// The link of the bracket at `module`. Undefined for other modules.
  [[nodiscard]] Link link(std::uint64_t module) const {
    const ShortLink found = links_[module];
    if (found.distance == kNoPartner) [[unlikely]] {
      return {kNone, 0};
    }
    if (found.distance == kIsLong) [[unlikely]] {
      return longLinks_.at(module);
    }
    return {module + static_cast<std::uint64_t>(static_cast<std::int64_t>(found.distance)), found.parameterCount};
  }

 private:
  static constexpr std::int32_t kNoPartner = 0;
  static constexpr std::int32_t kIsLong = std::numeric_limits<std::int32_t>::min();  // the link is in longLinks_

  struct ShortLink {
    std::int32_t distance;         // to the partner, negative at `]`; or one of the two values above
    std::uint32_t parameterCount;  // parameters of all modules between the two
  };
  /// Links the brackets of [first, end), whose parameters begin at `offset`, with each other and with those in `open`.
  /// Leaves the brackets without partner in `open`. Calls onClosed(Open) for a `]` without partner and onLong(Branch)
  /// for a branch that is too long. Returns the offset behind the last module. Several threads may link different
  /// stretches.
  template <typename OnClosed, typename OnLong>
  std::uint64_t linkStretch(const core::ModuleTypeId* types, std::uint64_t first, std::uint64_t end,
                            std::uint64_t offset, core::Buffer<Open>& open, OnClosed onClosed, OnLong onLong);
  [[nodiscard]] bool isLong(std::uint64_t distance, std::uint64_t parameterCount) const {
    return distance > longestShortBranch_ || parameterCount > longestShortBranch_;
  }
  void linkShort(std::uint64_t open, std::uint64_t distance, std::uint64_t parameterCount);
  void linkLong(const Branch& branch);

  ModuleFinder brackets_;
  std::vector<std::uint32_t> shape_;  // by module type: equal for types that can replace each other without new links
  std::uint64_t longestShortBranch_;
  core::Buffer<ShortLink> links_;                      // by module; defined at brackets only (moduleCount)
  std::unordered_map<std::uint64_t, Link> longLinks_;  // by module
  core::Buffer<Open> open_;                            // brackets without a partner so far
  std::uint64_t indexed_ = 0;                          // modules seen
  std::uint64_t parameterOffset_ = 0;                  // of the next module
};

}  // namespace espalier::derivation

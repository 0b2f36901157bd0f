#pragma once

#include <cstdint>
#include <vector>

#include "engine/core/buffer.h"
#include "engine/derivation/module_string.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Links between the brackets of a string, so that a context search skips a branch in one move. Eight bytes a module,
/// written (and touched) at brackets only.
class StringIndex {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  struct Link {
    std::uint32_t partner;         // index of the other bracket, or kNone when it has none
    std::uint32_t parameterCount;  // parameters of all modules between the two
  };

  /// The longest string that links can describe.
  static constexpr std::uint64_t kMaximumModules = 0xFFFFFFFE;

  void clear();

  /// Adds the modules from where the last call ended to the end of `string`. A `[` that is still open has no partner
  /// yet. O(new modules).
  void extend(const language::Program& program, const ModuleString& string);

  /// The link of the bracket at `module`. Undefined for other modules.
  [[nodiscard]] const Link& link(std::uint64_t module) const { return links_[module]; }

 private:
  struct Open {
    std::uint32_t module;
    std::uint64_t parameterOffset;  // of the first module inside
  };
  core::Buffer<Link> links_;           // by module; defined at brackets only (moduleCount)
  std::vector<Open> open_;             // brackets without a partner so far
  std::uint64_t indexed_ = 0;          // modules seen
  std::uint64_t parameterOffset_ = 0;  // of the next module
};

}  // namespace espalier::derivation

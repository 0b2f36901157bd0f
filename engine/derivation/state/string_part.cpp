#include "engine/derivation/state/string_part.h"

namespace espalier::derivation {

StringPart findCutPart(const language::Program& program, std::span<const core::ModuleTypeId> types,
                       std::uint64_t module, std::uint64_t offset) {
  StringPart part{module + 1, module + 1, offset + program.arity[types[module]], 0};
  part.endParameter = part.firstParameter;
  std::uint64_t depth = 0;
  for (; part.endModule < types.size(); ++part.endModule) {
    const core::ModuleTypeId type = types[part.endModule];
    if (type == program.openBranch) {
      ++depth;
    } else if (type == program.closeBranch) {
      if (depth == 0) {
        break;
      }
      --depth;
    }
    part.endParameter += program.arity[type];
  }
  return part;
}

}  // namespace espalier::derivation

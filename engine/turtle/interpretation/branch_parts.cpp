#include "engine/turtle/interpretation/branch_parts.h"

namespace espalier::turtle {

std::vector<BranchPart> findBranchParts(const InterpretationTables& tables, std::span<const std::uint16_t> arity,
                                        std::span<const core::ModuleTypeId> types, std::uint64_t smallest,
                                        std::uint64_t largest) {
  using Role = InterpretationTables::Role;
  struct Open {
    std::uint64_t module;
    std::uint64_t offset;
  };
  std::vector<BranchPart> parts;
  std::vector<Open> open;
  std::uint64_t offset = 0;
  for (std::uint64_t i = 0; i < types.size(); ++i) {
    const core::ModuleTypeId type = types[i];
    const Role role = tables.roleOf[type];
    if (role == Role::OpenBranch) {
      open.push_back({i + 1, offset});
    } else if (role == Role::CloseBranch && !open.empty()) {
      const Open start = open.back();
      open.pop_back();
      const std::uint64_t size = i - start.module;
      if (size >= smallest && size <= largest) {
        // branches inside it were found before it
        while (!parts.empty() && parts.back().firstModule > start.module) {
          parts.pop_back();
        }
        parts.push_back({start.module, i, start.offset, offset});
      }
    }
    offset += arity[type];
  }
  return parts;
}

}  // namespace espalier::turtle

#include "engine/derivation/state/module_origins.h"

namespace espalier::derivation {

void ModuleOrigins::add(const language::Program& program, const ModuleString& old, std::uint64_t oldBegin,
                        std::uint64_t oldEnd, const ModuleString& made, std::uint64_t begin, std::uint64_t end) {
  from_.resize(begin, kNew);
  std::uint64_t depth = 0;
  for (std::uint64_t i = begin; i < end; ++i) {
    const core::ModuleTypeId type = made.types()[i];
    std::uint64_t from = kNew;
    if (type == program.closeBranch && depth > 0) {
      --depth;
    } else if (depth == 0) {
      // a predecessor of several modules is continued in its order
      for (std::uint64_t k = oldBegin; k < oldEnd; ++k) {
        if (program.symbolOf[old.types()[k]] == program.symbolOf[type]) {
          from = k;
          oldBegin = k + 1;
          break;
        }
      }
      // a bracket that is copied stands alone
      depth += type == program.openBranch && end - begin > 1 ? 1 : 0;
    } else if (type == program.openBranch) {
      ++depth;
    }
    from_.push_back(from);
  }
}

}  // namespace espalier::derivation

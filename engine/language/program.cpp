#include "engine/language/program.h"

namespace espalier::language {

core::ModuleTypeId Program::findType(std::string_view name, std::uint16_t arityWanted) const {
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (types[i].arity == arityWanted && symbols[types[i].symbol].name == name) {
      return static_cast<core::ModuleTypeId>(i);
    }
  }
  return core::kNoModuleType;
}

}  // namespace espalier::language

#include "engine/derivation/parallel/shared_output.h"

namespace espalier::derivation {

SharedOutput::SharedOutput(ModuleString& string) : string_(&string) {
  typePages_.cover(types(), string.typeBuffer().capacity() * sizeof(core::ModuleTypeId));
  parameterPages_.cover(parameters(), string.parameterBuffer().capacity() * sizeof(double));
}

bool SharedOutput::holds(std::uint64_t moduleCount, std::uint64_t parameterCount) const {
  return moduleCount <= string_->typeBuffer().capacity() && parameterCount <= string_->parameterBuffer().capacity();
}

void SharedOutput::prepare(std::uint64_t firstModule, std::uint64_t endModule, std::uint64_t firstParameter,
                           std::uint64_t endParameter) {
  typePages_.prepare(firstModule * sizeof(core::ModuleTypeId), endModule * sizeof(core::ModuleTypeId));
  parameterPages_.prepare(firstParameter * sizeof(double), endParameter * sizeof(double));
}

void SharedOutput::finish(std::uint64_t moduleCount, std::uint64_t parameterCount) {
  string_->typeBuffer().resize(moduleCount);
  string_->parameterBuffer().resize(parameterCount);
}

}  // namespace espalier::derivation

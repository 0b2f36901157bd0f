#include "engine/derivation/system_tables.h"

#include <algorithm>

namespace espalier::derivation {

SystemTables::SystemTables(const language::Program& program, std::uint32_t systemIndex)
    : system(&program.systems[systemIndex]),
      rules(program, *system),
      plan(program, *system),
      batches(program, *system, rules, plan) {
  hasDecomposition = !system->decomposition.productions.empty() && system->decomposition.maximumDepth > 0;
  for (const language::Production& production : system->productions.productions) {
    const bool isDecomposed =
        hasDecomposition && std::any_of(production.successor.begin(), production.successor.end(),
                                        [&](const language::SuccessorModule& module) {
                                          return !system->decomposition.index.candidates(module.type).empty();
                                        });
    decomposes.push_back(isDecomposed ? 1 : 0);
    isProducedBackwards = isProducedBackwards || !production.newRightContext.empty();
  }
}

std::vector<SystemTables> makeSystemTables(const language::Program& program) {
  std::vector<SystemTables> tables;
  tables.reserve(program.systems.size());
  for (std::uint32_t i = 0; i < program.systems.size(); ++i) {
    tables.emplace_back(program, i);
  }
  return tables;
}

InstanceState makeInstance(const language::Program& program, std::uint32_t systemIndex) {
  const language::LSystem& system = program.systems[systemIndex];
  InstanceState instance;
  instance.system = systemIndex;
  instance.variables.assign(system.variables.size(), 0.0);
  instance.elements.assign(system.arrayElementCount, 0.0);
  for (const language::ArrayVariable& array : system.arrays) {
    std::copy(array.initial.begin(), array.initial.end(),
              instance.elements.begin() + static_cast<std::ptrdiff_t>(array.firstElement));
  }
  return instance;
}

bool isCall(const language::Program& program, core::ModuleTypeId type) {
  return program.arity[type] > 0 && program.nameOf(type) == "?";
}

}  // namespace espalier::derivation

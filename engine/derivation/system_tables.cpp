#include "engine/derivation/system_tables.h"

#include <algorithm>

#include "engine/language/arithmetic.h"

namespace espalier::derivation {
namespace {

using language::Function;
using language::Operation;

/// Whether evaluating the code has no lasting effect but the count of the module's draws.
bool hasNoEffect(const language::Program& program, const language::Expression& expression) {
  if (expression.kind != language::Expression::Kind::Code || expression.isPure) {
    return true;
  }
  return std::all_of(program.code.begin() + expression.code.begin, program.code.begin() + expression.code.end,
                     [](const language::Instruction& instruction) {
                       if (instruction.operation == Operation::Call) {
                         const auto function = static_cast<Function>(instruction.operand);
                         return function != Function::Srand && function != Function::Stop &&
                                function != Function::SetDerivationLength && function != Function::Play;
                       }
                       return instruction.operation < Operation::StoreSlot ||
                              (instruction.operation >= Operation::Pop && instruction.operation < Operation::Call);
                     });
}

/// Whether code calls a function that draws.
bool draws(const language::Program& program, const language::CodeRange& code) {
  return std::any_of(program.code.begin() + code.begin, program.code.begin() + code.end,
                     [](const language::Instruction& instruction) {
                       return instruction.operation == Operation::Call &&
                              language::drawsRandom(static_cast<Function>(instruction.operand));
                     });
}

/// Whether anything in a production draws, also beside variables (Production::drawsRandom means draws alone).
bool draws(const language::Program& program, const language::Production& production) {
  const auto drawsIn = [&](const language::Expression& expression) {
    return expression.kind == language::Expression::Kind::Code && draws(program, expression.code);
  };
  return draws(program, production.preBlock) || draws(program, production.postBlock) ||
         (production.condition && drawsIn(*production.condition)) ||
         (production.probability && drawsIn(*production.probability)) ||
         std::any_of(production.expressions.begin(), production.expressions.end(), drawsIn);
}

/// Whether the result of a production depends only on the old string, the variables and the draws of the module.
bool isOrderFree(const language::Program& program, const language::Production& production) {
  const auto isFree = [&](const language::Expression& expression) { return hasNoEffect(program, expression); };
  return production.newLeftContext.empty() && production.newRightContext.empty() && production.preBlock.empty() &&
         production.postBlock.empty() && (!production.condition || isFree(*production.condition)) &&
         (!production.probability || isFree(*production.probability)) &&
         std::all_of(production.expressions.begin(), production.expressions.end(), isFree);
}

}  // namespace

SystemTables::SystemTables(const language::Program& program, std::uint32_t systemIndex)
    : system(&program.systems[systemIndex]),
      rules(program, *system),
      plan(program, *system),
      decomposition(BatchPlan::ofDecomposition(program, *system, rules, plan)),
      batches(program, *system, rules, plan, decomposition ? &*decomposition : nullptr) {
  hasContexts = looksAround(system->productions) || looksAround(system->decomposition);
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
  isInside.resize(program.moduleTypeCount(), 0);
  isOrderFree = true;
  for (const language::ProductionList* list : {&system->productions, &system->decomposition}) {
    for (const language::Production& production : list->productions) {
      isOrderFree = isOrderFree && derivation::isOrderFree(program, production);
      drawsRandom = drawsRandom || draws(program, production);
      for (std::size_t i = 1; i < production.predecessor.size(); ++i) {
        isInside[production.predecessor[i].type] = 1;
      }
    }
  }
}

bool looksAround(const language::ProductionList& list) {
  return std::any_of(list.productions.begin(), list.productions.end(), [](const language::Production& production) {
    return !production.leftContext.empty() || !production.rightContext.empty();
  });
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

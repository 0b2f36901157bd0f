#include "engine/derivation/plan_text.h"

#include <unordered_map>

#include "engine/derivation/system_tables.h"

namespace espalier::derivation {
namespace {

/// The rules of a plan by their productions.
using Rules = std::unordered_map<const language::Production*, const BatchRule*>;

const char* contextText(const Rules& rules, const language::Production& production) {
  const auto found = rules.find(&production);
  if (found == rules.end()) {
    return "; a production before it always applies";
  }
  const BatchRule& rule = *found->second;
  if (rule.context == BatchRule::Context::Near) {
    return "; the nearest neighbours are found for all modules at once";
  }
  if (rule.sharesPlaces) {
    return "; a production before it has found the same neighbours";
  }
  return rule.context == BatchRule::Context::Searched
             ? "; its neighbours are searched for all modules at once, one element of the context after the other"
             : "";
}

std::string wayText(const language::Program& program, const SystemTables& tables, const Rules& rules,
                    const language::Production& production) {
  const core::ModuleTypeId type = production.predecessor[0].type;
  if (program.hasSubSystems) {
    return "one module at a time: the model calls sub-L-systems";
  }
  if (tables.isProducedBackwards) {
    return "one module at a time, from right to left: a production has a context `>>`";
  }
  if (program.compatibility != core::Compatibility::Espalier && tables.system->isStochastic) {
    return "one module at a time: the compatible modes draw a number for each module";
  }
  const BatchPlan& plan = tables.batches;
  switch (plan.classOf(type)) {
    case BatchPlan::Class::Fixed:
    case BatchPlan::Class::Kept:
    case BatchPlan::Class::Cut:
      return "a fixed block of modules is copied";
    case BatchPlan::Class::Group:
      return std::string("in batches") + contextText(rules, production);
    case BatchPlan::Class::General:
      break;
  }
  return std::string(tables.plan[type].kind == TypePlan::Kind::General ? "one module at a time: "
                                                                       : "one module at a time, by a table: ") +
         plan.problemOf(type);
}

}  // namespace

std::string planText(const language::Program& program) {
  std::string text;
  for (const SystemTables& tables : makeSystemTables(program)) {
    text += "L-system " + tables.system->name + "\n";
    Rules rules;
    for (const BatchRule& rule : tables.batches.rules()) {
      rules.emplace(rule.production, &rule);
    }
    const auto& productions = tables.system->productions.productions;
    for (std::size_t i = 0; i < productions.size(); ++i) {
      text += "production " + std::to_string(i) + ": " + productions[i].text + "\n  " +
              wayText(program, tables, rules, productions[i]) + "\n";
    }
    if (tables.hasDecomposition) {
      text += "decomposition\n  ";
      text += tables.decomposition ? "in batches, level by level\n" : "one module at a time\n";
    }
  }
  return text;
}

}  // namespace espalier::derivation

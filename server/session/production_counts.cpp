#include "server/session/production_counts.h"

#include "engine/core/work_meter.h"

namespace espalier::server {

RunCounts runCounts(const simulation::Programs& programs, const simulation::ProductionUses& uses) {
  RunCounts counts;
  counts.since = uses.since;
  counts.step = uses.step;
  const auto add = [&](const language::Program& program, const language::ProductionList& list) {
    for (const language::Production& production : list.productions) {
      core::pollWork();
      const auto use = uses.uses.find(&production);
      const simulation::ProductionUse count = use == uses.uses.end() ? simulation::ProductionUse{} : use->second;
      counts.productions.push_back(
          {production.text, program.sourceMap.locate(production.range), count.last, count.total});
    }
  };
  for (const auto& program : programs) {
    for (const language::LSystem& system : program->systems) {
      add(*program, system.productions);
      add(*program, system.decomposition);
    }
  }
  return counts;
}

}  // namespace espalier::server

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/result.h"
#include "clients/espalier/sweep/module_expressions.h"
#include "clients/espalier/sweep/plan.h"
#include "engine/core/simulation_error.h"
#include "engine/core/streams.h"
#include "engine/simulation/simulation.h"

namespace espalier::command {

/// The measures of a plan, ready for the plants of one Program. Const after make, and shared by all workers.
class Measures {
 public:
  /// A problem has a line for each mistake, with the place in the plan.
  [[nodiscard]] static Result<Measures> make(const std::vector<MeasureDefinition>& definitions,
                                             const language::Program& program, const language::CompileInput& input,
                                             core::FileProvider& files);
  /// The same for a Program of the same model with other macros.
  [[nodiscard]] Result<Measures> remade(const language::Program& program, const language::CompileInput& input,
                                        core::FileProvider& files) const;

  /// Names of the values: NAME, NAME_STEP when a measure names its steps, NAME_1 ... NAME_n of a profile.
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }

  /// Takes the measures of the present step into `values` (columns). `isLast`: of the last step too. Values that the
  /// plant does not have stay as they are. An error: the plant cannot be drawn, or an expression failed.
  [[nodiscard]] std::optional<core::SimulationError> take(const simulation::Simulation& simulation, bool isLast,
                                                          std::vector<double>& values) const;
  /// Whether a measure is taken at a step before the last.
  [[nodiscard]] bool areTakenAt(std::uint64_t step) const;
  /// The first measure with a step above `last`, and that step; nothing when there is none.
  [[nodiscard]] std::optional<std::pair<std::string, std::uint64_t>> takenAfter(std::uint64_t last) const;

 private:
  struct Measure {
    MeasureDefinition definition;
    std::size_t firstColumn = 0;
    std::vector<bool> types;     // by module type: over which the measure is taken; Mtg: the vertices; may be empty
    std::size_t expression = 0;  // of expressions_; kNone: the measure only counts
    std::size_t name = 0;        // place of definition.what in the names of its kind, or slot of the variable
  };
  static constexpr std::size_t kNone = ~std::size_t{0};

  struct Wanted;
  void takeModules(const simulation::Simulation& simulation, const std::vector<Wanted>& wanted,
                   std::vector<double>& values) const;

  std::vector<MeasureDefinition> definitions_;
  std::vector<std::string> columns_;
  std::vector<Measure> measures_;
  std::shared_ptr<const ModuleExpressions> expressions_;
};

}  // namespace espalier::command

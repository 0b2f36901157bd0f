#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "clients/espalier/result.h"
#include "clients/espalier/sweep/module_pattern.h"
#include "engine/core/streams.h"
#include "engine/derivation/expressions/evaluator.h"
#include "engine/derivation/expressions/random_source.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/language/program.h"

namespace espalier::command {

/// An expression of a plan over the parameters of a module, and the condition for modules that count.
struct ModuleExpression {
  std::string place;  // in the plan, for messages
  ModulePattern of;
  std::string value;  // empty: 1
  std::string where;  // empty: every module
};

/// Compiled expressions. They may use the parameters' names, the variables of the main L-system, the macros and the
/// functions of the model, Q and Z. The compiler of the language compiles them, as productions of a model of their own.
class ModuleExpressions {
 public:
  ModuleExpressions() = default;

  /// Compiles `expressions` for a model. `input` and `files` are those of the model. A problem names the place in the
  /// plan.
  [[nodiscard]] static Result<ModuleExpressions> compile(std::vector<ModuleExpression> expressions,
                                                         const language::Program& model,
                                                         const language::CompileInput& input,
                                                         core::FileProvider& files);

  /// Whether the macros of the model count: then other macros need other compiled expressions.
  [[nodiscard]] bool dependsOnMacros() const { return dependsOnMacros_; }

  /// The values of expressions in one state of a plant.
  class Reader {
   public:
    /// Expressions and model must outlive the object. `messages` receives warnings: a division by 0.
    Reader(const ModuleExpressions& expressions, const language::Program& model, const derivation::PlantState& plant,
           core::MessageSink messages);
    /// The value for a module with these parameters; nothing when the condition is false. Throws
    /// core::SimulationFailure: too many loop iterations.
    [[nodiscard]] std::optional<double> value(std::size_t expression, std::span<const double> parameters);

   private:
    const ModuleExpressions* expressions_;
    derivation::PlantState state_;
    derivation::RandomSource random_;
    derivation::Evaluator evaluator_;
    std::vector<double> frame_;
  };

 private:
  std::shared_ptr<const language::Program> program_;  // null: there are no expressions
  std::size_t system_ = 0;                            // whose productions hold the expressions, in order
  std::vector<bool> hasCondition_;
  bool dependsOnMacros_ = false;
};

}  // namespace espalier::command

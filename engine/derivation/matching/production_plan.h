#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/language/arithmetic.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// An expression in the form that costs least to evaluate. Its operands are numbers of one array: the formal parameters
/// of the module, and from ProductionPlan::firstConstant on the constants of the plan.
struct QuickValue {
  enum class Form : std::uint8_t {
    Constant,  // numbers[a]
    Slot,      // numbers[a]
    Operator,  // numbers[a] operation numbers[b]
    Code,      // by the Evaluator
  };
  Form form = Form::Constant;
  language::Operation operation = language::Operation::LoadSlot;  // Constant, Slot: numbers[a] as it is
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  const language::Expression* expression = nullptr;  // in the Program
};

/// The value of a form that needs no Evaluator, with the same bits as the Evaluator's.
[[nodiscard]] inline double quickValue(const QuickValue& value, const double* numbers) {
  const double a = numbers[value.a];
  const double b = numbers[value.b];
  switch (value.operation) {
    case language::Operation::Add:
      return a + b;
    case language::Operation::Subtract:
      return a - b;
    case language::Operation::Multiply:
      return a * b;
    case language::Operation::Divide:
      return a / b;
    case language::Operation::Equal:
      return language::toNumber(a == b);
    case language::Operation::NotEqual:
      return language::toNumber(a != b);
    case language::Operation::Less:
      return language::toNumber(a < b);
    case language::Operation::LessEqual:
      return language::toNumber(a <= b);
    case language::Operation::Greater:
      return language::toNumber(a > b);
    case language::Operation::GreaterEqual:
      return language::toNumber(a >= b);
    default:
      return a;
  }
}

/// The index of the chosen weight. The probability of each is weight / sum; weights are in file order, `draw` is
/// uniform. Espalier's own mode takes draws in (0, 1] and doubles. The reference takes draws in [0, 1) and keeps the
/// sum and the remainder in 32-bit floats. When all weights are 0 the first is chosen.
[[nodiscard]] std::size_t chooseByWeight(std::span<const double> weights, double draw, bool usesFloats);

/// Whether a production looks at neighbours in the old string.
[[nodiscard]] bool hasContexts(const language::Production& production);

/// A production whose predecessor is one module: contexts, a condition and a weight decide.
struct QuickRule {
  const language::Production* production = nullptr;  // in the Program
  bool hasContexts = false;
  bool hasCondition = false;
  bool hasWeight = false;
  bool hasBefore = false;  // a block before the condition, which assigns no formal parameter
  bool hasBehind = false;  // a block behind it
  QuickValue condition;
  QuickValue weight;             // 1 when the production has no probability
  std::uint32_t firstType = 0;   // ProductionPlan::types: the successor
  std::uint32_t length = 0;      // modules of the successor
  std::uint32_t firstValue = 0;  // ProductionPlan::values: its parameters
  std::uint32_t valueCount = 0;
};

/// The way in which the PlainScan rewrites the modules of one type.
struct TypePlan {
  static constexpr std::size_t kInlineTypes = 16;

  enum class Kind : std::uint8_t {
    Fixed,  // the same modules every time: a block of types, and the module's own parameters when it stands for itself
    Rules,  // QuickRules, the first whose condition holds
    Weights,           // QuickRules, one chosen by weight among those whose condition holds
    BlocksOrContexts,  // the same for QuickRules of which some have these; contexts only where no weight decides
    General,           // everything else
  };
  std::array<core::ModuleTypeId, kInlineTypes> types{};  // Fixed: the block, when it is no longer than this
  std::uint32_t length = 0;                              // Fixed: modules of the block
  std::uint32_t firstType = 0;                           // Fixed: the block in ProductionPlan::types
  std::uint32_t firstRule = 0;                           // Rules and what follows: in ProductionPlan::rules
  std::uint32_t ruleCount = 0;
  std::uint16_t arity = 0;   // parameters of the module
  std::uint16_t copied = 0;  // Fixed: parameters copied, 0 or all
  Kind kind = Kind::General;
  bool drawsRandom = false;  // the same: code may draw
  bool usesCode = false;     // the same: code needs the Evaluator
};

/// The ways in which one L-system rewrites its module types, by type. A table over the Program, which must outlive it.
class ProductionPlan {
 public:
  /// Places behind the formal parameters.
  static constexpr std::size_t kFreePlaces = 4;

  ProductionPlan(const language::Program& program, const language::LSystem& system);

  [[nodiscard]] const TypePlan& operator[](core::ModuleTypeId type) const { return plans_[type]; }
  [[nodiscard]] const TypePlan* plans() const { return plans_.data(); }
  [[nodiscard]] const QuickRule* rules() const { return rules_.data(); }
  /// All successors, one after the other, and then kInlineTypes further entries, so that a read may pass the end.
  [[nodiscard]] const core::ModuleTypeId* types() const { return types_.data(); }
  [[nodiscard]] const QuickValue* values() const { return values_.data(); }
  /// The place of the first constant among the numbers of QuickValues. Behind the formal parameters some places are
  /// free, so that a copy of parameters may pass their end.
  [[nodiscard]] std::size_t firstConstant() const { return firstConstant_; }
  [[nodiscard]] const std::vector<double>& constants() const { return constants_; }

  /// The most modules and parameters that one module of a kind other than General becomes.
  [[nodiscard]] std::uint64_t largestLength() const { return largestLength_; }
  [[nodiscard]] std::uint64_t largestParameterCount() const { return largestParameterCount_; }

 private:
  void planType(const language::Program& program, const language::LSystem& system, core::ModuleTypeId type);
  [[nodiscard]] QuickValue makeValue(const language::Program& program, const language::Expression& expression);
  [[nodiscard]] std::uint32_t addConstant(double value);
  void makeFixed(TypePlan& plan, std::uint32_t firstType, std::uint32_t length);
  std::uint32_t addRule(const language::Program& program, const language::Production& production, bool usesWeights);

  std::vector<TypePlan> plans_;  // by module type (moduleTypeCount)
  std::vector<QuickRule> rules_;
  std::vector<core::ModuleTypeId> types_;
  std::vector<QuickValue> values_;
  std::size_t firstConstant_;
  std::vector<double> constants_;
  std::uint64_t largestLength_ = 1;
  std::uint64_t largestParameterCount_ = 0;
};

}  // namespace espalier::derivation

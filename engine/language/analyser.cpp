#include "engine/language/analyser.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "engine/language/arithmetic.h"
#include "engine/language/constant_evaluation.h"

namespace espalier::language {

// ---- scopes

Binding Analyser::Scope::addVariable(const std::string& name) {
  Binding binding;
  if (isProduction_) {
    binding = {Binding::Kind::Static, static_cast<std::uint32_t>(statics_.size())};
    const bool isNew = production_.emplace(name, binding).second;
    if (!isNew) {
      return production_.at(name);
    }
    statics_.push_back(name);
    return binding;
  }
  binding = {Binding::Kind::Variable, static_cast<std::uint32_t>(system_.variables.size())};
  const bool isNew = lsystem_.emplace(name, binding).second;
  if (!isNew) {
    return lsystem_.at(name);
  }
  system_.variables.push_back(name);
  return binding;
}

Binding Analyser::Scope::addShared(const std::string& name) {
  const Binding binding{Binding::Kind::Variable, static_cast<std::uint32_t>(system_.variables.size())};
  const auto [found, isNew] = lsystem_.emplace(name, binding);
  if (isNew) {
    system_.variables.push_back(name);
  }
  return found->second;
}

Binding Analyser::Scope::find(const std::string& name) const {
  if (const auto local = production_.find(name); local != production_.end()) {
    return local->second;
  }
  const auto shared = lsystem_.find(name);
  return shared == lsystem_.end() ? Binding{} : shared->second;
}

std::vector<std::string_view> Analyser::Scope::names() const {
  std::vector<std::string_view> result;
  for (const auto& [name, binding] : production_) {
    result.push_back(name);
  }
  for (const auto& [name, binding] : lsystem_) {
    if (!production_.contains(name)) {
      result.push_back(name);
    }
  }
  return result;
}

// ---- the model

Analyser::Analyser(std::string_view text, core::Compatibility compatibility, const core::Limits& limits,
                   ModelSyntax& model, MessageList& messages)
    : text_(text), compatibility_(compatibility), limits_(limits), model_(model), messages_(messages) {}

std::string Analyser::describePlace() const {
  if (predecessor_.begin == predecessor_.end) {
    return place_;
  }
  return place_ + " of " + foldBlanks(text_.substr(predecessor_.begin, predecessor_.end - predecessor_.begin));
}

void Analyser::analyse() {
  if (model_.systems.empty()) {
    return;
  }
  // in the reference only a derivation length defines Q and Z
  hasSteps_ =
      compatibility_ == core::Compatibility::Espalier || model_.systems.front().derivationLength != kNoExpression;
  for (std::size_t i = 0; i < model_.systems.size(); ++i) {
    analyseSystem(i);
  }
}

void Analyser::analyseSystem(std::size_t index) {
  LSystemSyntax& system = model_.systems[index];
  Scope scope(system, model_.staticNames);
  predecessor_ = {};
  unknown_.clear();
  evaluateItems(system, index == 0);
  defineArrays(system, scope);
  defineVariables(system, scope);
  collectAssignedInProductions(system);
  analyseBlocks(system, scope);
  analyseList(system.productions, scope, "the productions");
  analyseList(system.decomposition, scope, "the decomposition");
  analyseList(system.homomorphism, scope, "the homomorphism");

  const auto hasProbability = [](const ProductionSyntax& production) {
    return production.probability != kNoExpression;
  };
  const bool hasProbabilities =
      std::any_of(system.productions.productions.begin(), system.productions.productions.end(), hasProbability);
  system.isStochastic =
      system.seed != kNoExpression || (compatibility_ == core::Compatibility::Espalier && hasProbabilities);
  warnAboutProbabilities(system);
}

// ---- items that are constant

double Analyser::constantItem(ExpressionIndex expression, std::string_view name, double least) {
  place_ = name;
  predecessor_ = {};
  // variables have no value yet; functions are resolved as usual
  std::vector<ExpressionIndex> open{expression};
  ExpressionIndex first = expression;
  bool isConstant = true;
  while (!open.empty()) {
    ExpressionNode& node = at(open.back());
    first = std::min(first, open.back());
    open.pop_back();
    open.insert(open.end(), node.children.begin(), node.children.end());
    if (node.kind == ExpressionKind::Name) {
      if (node.text == "pi" && compatibility_ == core::Compatibility::Espalier) {
        node.binding.kind = Binding::Kind::Pi;
      } else {
        messages_.warning(node.range, "unknown name '" + node.text + "' in " + place_ + ": its value is 0",
                          "variables have no value yet when a model is read; use #define");
        node.kind = ExpressionKind::Number;
        node.number = 0.0;
      }
    } else if (node.kind == ExpressionKind::Call) {
      const std::size_t before = messages_.errorCount();
      Scope none(model_.systems.front(), model_.staticNames);
      resolveFunction(node, none);
      if (messages_.errorCount() > before) {
        return least;
      }
      if (node.callee != Callee::Function || !isArithmetic(node.function)) {
        messages_.error(node.nameRange, "'" + node.text + "' cannot be used in " + place_ + ", which must be constant");
        isConstant = false;
      }
    } else if (node.kind != ExpressionKind::Number && node.kind != ExpressionKind::Unary &&
               node.kind != ExpressionKind::Binary && node.kind != ExpressionKind::Conditional) {
      messages_.error(node.range, "expected a constant expression in " + place_);
      isConstant = false;
    }
  }
  if (!isConstant) {
    return least;
  }
  // the nodes of one expression are contiguous, children before their parents
  values_.resize(model_.expressions.size());
  for (ExpressionIndex i = first; i <= expression; ++i) {
    values_[i] = foldNode(model_.expressions[i], model_, values_, compatibility_);
  }
  if (!values_[expression].has_value()) {
    messages_.error(at(expression).range,
                    "the value of " + place_ + " is not a number: it divides by zero or is not finite");
    return least;
  }
  const double value = *values_[expression];
  if (value < least || value > 9.0e15) {
    messages_.warning(
        at(expression).range, "the value of " + place_ + " is out of range",
        "the program uses " + std::string(value < least ? "the least possible value" : "the largest possible value"));
  }
  return std::clamp(value, least, 9.0e15);
}

void Analyser::evaluateItems(LSystemSyntax& system, bool isMain) {
  if (system.seed != kNoExpression) {
    system.seedValue = static_cast<std::int64_t>(constantItem(system.seed, "'seed:'", -9.0e15));
  }
  if (system.derivationLength != kNoExpression) {
    const double length = constantItem(system.derivationLength, "'derivation length:'", 0.0);
    if (isMain) {
      model_.derivationLength = static_cast<std::uint64_t>(length);
    } else {
      messages_.warning(system.derivationLengthRange, "the derivation length of a sub-L-system has no effect",
                        "only that of the first L-system counts");
    }
  }
  for (ProductionListSyntax* list : {&system.decomposition, &system.homomorphism}) {
    if (list->maximumDepth != kNoExpression) {
      const double depth = constantItem(list->maximumDepth, "'maximum depth:'", 0.0);
      list->maximumDepthValue = static_cast<std::uint32_t>(std::min(depth, 4294967295.0));
    }
    if (list->seed != kNoExpression) {
      const double seed = constantItem(list->seed, "the homomorphism's 'seed:'", -9.0e15);
      list->seedValue = seed >= 0.0 ? std::optional<double>(seed) : std::nullopt;
    }
  }
}

// ---- variables of the L-system

void Analyser::defineArrays(LSystemSyntax& system, Scope& scope) {
  for (const ArraySyntax& array : system.arrays) {
    ArrayVariable variable;
    variable.name = array.name.text;
    variable.firstElement = system.arrayElementCount;
    std::uint64_t count = 1;
    for (const ExpressionIndex dimension : array.dimensions) {
      const double size = std::trunc(constantItem(dimension, "the size of array '" + array.name.text + "'", 1.0));
      count = size * static_cast<double>(count) > static_cast<double>(limits_.maximumArrayElements)
                  ? limits_.maximumArrayElements + 1
                  : count * static_cast<std::uint64_t>(size);
      variable.dimensions.push_back(static_cast<std::uint32_t>(std::min(size, 4294967295.0)));
    }
    if (scope.find(array.name.text).kind != Binding::Kind::Unbound) {
      messages_.error(array.name.range, "the array '" + array.name.text + "' is defined twice");
      continue;
    }
    // a wrong array is known, so that its uses are no further mistakes
    scope.addArray(array.name.text, static_cast<std::uint32_t>(system.arrayVariables.size()));
    if (count + system.arrayElementCount > limits_.maximumArrayElements) {
      messages_.error(array.range, "the arrays have more elements than the limit arrayElements (" +
                                       std::to_string(limits_.maximumArrayElements) + ")");
      count = 0;
    } else if (array.initial.size() > count) {
      messages_.error(array.range, "the array '" + array.name.text + "' has " + std::to_string(count) +
                                       " elements, found " + std::to_string(array.initial.size()) + " values");
    } else {
      for (const ExpressionIndex value : array.initial) {
        variable.initial.push_back(constantItem(value, "the values of array '" + array.name.text + "'", -9.0e15));
      }
    }
    variable.initial.resize(count, 0.0);
    system.arrayElementCount += static_cast<std::uint32_t>(count);
    system.arrayVariables.push_back(std::move(variable));
  }
}

void Analyser::defineVariables(LSystemSyntax& system, Scope& scope) {
  for (const NameSyntax& name : system.externals) {
    if (scope.find(name.text).kind != Binding::Kind::Unbound) {
      messages_.error(name.range, "the variable '" + name.text + "' is defined twice");
      continue;
    }
    system.externalSlots.push_back(scope.addVariable(name.text).index);
    if (&system == &model_.systems.front()) {
      messages_.warning(name.range, "no L-system calls the first one: its external variable '" + name.text +
                                        "' is an ordinary variable with the value 0");
    }
  }
  for (const Block* block : {&system.start, &system.startEach, &system.endEach, &system.end}) {
    for (const NameSyntax& name : assignedNames(model_, block->statements)) {
      if (scope.find(name.text).kind == Binding::Kind::Unbound) {
        scope.addVariable(name.text);
      }
      if (hasSteps_ && (name.text == "Q" || name.text == "Z")) {
        messages_.warning(name.range, "'" + name.text + "' is assigned and is now an ordinary variable",
                          "without the assignment it is the " +
                              std::string(name.text == "Q" ? "number of the current step" : "derivation length"));
      }
    }
  }
}

void Analyser::collectAssignedInProductions(const LSystemSyntax& system) {
  assignedInProductions_.clear();
  for (const ProductionListSyntax* list : {&system.productions, &system.decomposition, &system.homomorphism}) {
    for (const ProductionSyntax& production : list->productions) {
      for (const Block* block : {&production.preBlock, &production.postBlock}) {
        for (NameSyntax& name : assignedNames(model_, block->statements)) {
          assignedInProductions_.insert(std::move(name.text));
        }
      }
    }
  }
}

void Analyser::analyseBlocks(LSystemSyntax& system, Scope& scope) {
  predecessor_ = {};
  resolveBlock(system.start, scope, "Start");
  resolveBlock(system.startEach, scope, "StartEach");
  resolveBlock(system.endEach, scope, "EndEach");
  resolveBlock(system.end, scope, "End");
  place_ = "the axiom";
  resolveModules(system.axiom, scope);
}

// ---- productions

void Analyser::analyseList(ProductionListSyntax& list, Scope& scope, std::string_view name) {
  for (ProductionSyntax& production : list.productions) {
    scope.beginProduction();
    analyseProduction(production, scope);
    scope.endProduction();
    if (production.probability != kNoExpression && name != "the productions") {
      messages_.warning(at(production.probability).range, "a probability has no effect in " + std::string(name),
                        "the first production that matches is applied there");
    }
  }
  predecessor_ = {};
}

void Analyser::bindFormals(ProductionSyntax& production, Scope& scope) {
  std::uint32_t slot = 0;
  const auto bind = [&](FormalModuleSyntax& module) {
    module.firstSlot = static_cast<std::uint16_t>(slot);
    for (const NameSyntax& parameter : module.parameters) {
      scope.addFormal(parameter.text, slot++);
    }
  };
  // the first binding of a name wins: left context, predecessor, right context, then the new contexts
  for (ContextElementSyntax& element : production.leftContext) {
    bind(element.module);
  }
  for (FormalModuleSyntax& module : production.predecessor) {
    bind(module);
  }
  for (std::vector<ContextElementSyntax>* context :
       {&production.rightContext, &production.newLeftContext, &production.newRightContext}) {
    for (ContextElementSyntax& element : *context) {
      bind(element.module);
    }
  }
  if (slot > 0xFFFFU) {
    messages_.error(production.predecessorRange, "the production has more than 65535 formal parameters");
  }
  production.slotCount = static_cast<std::uint16_t>(slot);
}

void Analyser::analyseProduction(ProductionSyntax& production, Scope& scope) {
  predecessor_ = production.predecessorRange;
  bindFormals(production, scope);
  // a name that only productions assign is local to its production
  for (const Block* block : {&production.preBlock, &production.postBlock}) {
    for (const NameSyntax& name : assignedNames(model_, block->statements)) {
      if (scope.find(name.text).kind == Binding::Kind::Unbound) {
        scope.addVariable(name.text);
        if (hasSteps_ && (name.text == "Q" || name.text == "Z")) {
          messages_.warning(name.range, "'" + name.text + "' is assigned and is now a variable of this production",
                            "elsewhere it is the " +
                                std::string(name.text == "Q" ? "number of the current step" : "derivation length"));
        }
      }
    }
  }
  resolveBlock(production.preBlock, scope, "a block");
  place_ = "the condition";
  if (production.condition != kNoExpression) {
    resolve(production.condition, scope);
  }
  resolveBlock(production.postBlock, scope, "a block");
  place_ = "the successor";
  resolveModules(production.successor, scope);
  place_ = "the probability";
  if (production.probability != kNoExpression) {
    resolve(production.probability, scope);
  }
  production.isLabelled = reportedLabel_ == predecessor_;
}

void Analyser::warnAboutProbabilities(LSystemSyntax& system) {
  if (system.isStochastic) {
    return;
  }
  for (const ProductionSyntax& production : system.productions.productions) {
    if (production.probability != kNoExpression) {
      messages_.warning(
          at(production.probability).range,
          "probabilities are ignored: the L-system has no 'seed:', so the first production that matches is applied",
          "put 'seed: 1' before the axiom");
      return;
    }
  }
}

}  // namespace espalier::language

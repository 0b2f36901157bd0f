#include "engine/language/checks/model_checks.h"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/work_meter.h"
#include "engine/language/checks/formal_modules.h"
#include "engine/language/checks/habit_checks.h"
#include "engine/language/checks/module_checks.h"
#include "engine/language/checks/reach_checks.h"
#include "engine/language/checks/word_checks.h"
#include "engine/language/constant_evaluation.h"

namespace espalier::language {
namespace {

using Modules = std::vector<ModuleSyntax>;

class Checks {
 public:
  Checks(std::string_view text, const CheckedModel& checked, const ModelSyntax& model, MessageList& messages)
      : text_(text),
        isTranslation_(checked.origin == ModelOrigin::Translation),
        beginsElsewhere_(checked.beginsElsewhere),
        model_(model),
        messages_(messages),
        values_(foldConstants(model, checked.compatibility)) {}

  std::vector<std::string> run() {
    checkSubSystems();
    for (const LSystemSyntax& system : model_.systems) {
      checkBrackets(system.axiom, "the axiom");
      forLists(system, [&](const ProductionListSyntax& list) {
        const bool isStochastic = system.isStochastic && &list == &system.productions;
        if (isDrawing(system, list)) {
          return;
        }
        if (isStochastic) {
          checkWeights(list);
        } else {
          checkHidden(list);
        }
        for (const ProductionSyntax& production : list.productions) {
          checkBrackets(production.successor, "the successor of " + textOf(production.predecessorRange));
          checkContinuation(production);
          checkProbability(production);
        }
      });
    }
    checkPolygons();
    if (!isTranslation_) {
      checkHabits(text_, model_, messages_);
    }
    // about the letters of such words further messages would only repeat the first
    if (isTranslation_ || !checkWords(text_, model_, messages_)) {
      if (!beginsElsewhere_) {
        checkReach(text_, isTranslation_, model_, messages_);
      }
      checkUnread();
      return checkModules(text_, model_, messages_);
    }
    return {};
  }

 private:
  /// Whether a translation made the list: the drawing of its symbols.
  [[nodiscard]] bool isDrawing(const LSystemSyntax& system, const ProductionListSyntax& list) const {
    return isTranslation_ && &list == &system.homomorphism;
  }
  template <typename Action>
  static void forLists(const LSystemSyntax& system, Action action) {
    for (const ProductionListSyntax* list : {&system.productions, &system.decomposition, &system.homomorphism}) {
      action(*list);
    }
  }
  template <typename Action>
  void forModules(Action action) const {
    for (const LSystemSyntax& system : model_.systems) {
      action(system.axiom);
      forLists(system, [&](const ProductionListSyntax& list) {
        for (const ProductionSyntax& production : list.productions) {
          action(production.successor);
        }
      });
    }
  }
  [[nodiscard]] ModuleType typeOf(core::ModuleTypeId type) const { return model_.symbols.types()[type]; }
  [[nodiscard]] char characterOf(core::ModuleTypeId type) const {
    return model_.symbols[typeOf(type).symbol].character();
  }
  [[nodiscard]] std::string textOf(core::SourceRange range) const {
    return foldBlanks(text_.substr(range.begin, range.end - range.begin));
  }
  [[nodiscard]] std::optional<double> valueOf(ExpressionIndex expression) const { return values_[expression]; }

  // ---- branches

  void checkBrackets(const Modules& modules, const std::string& place) {
    std::vector<core::SourceRange> open;
    for (const ModuleSyntax& module : modules) {
      const char character = module.parameters.empty() ? characterOf(module.type) : '\0';
      if (character == '[') {
        open.push_back(module.range);
      } else if (character == ']' && !open.empty()) {
        open.pop_back();
      } else if (character == ']') {
        messages_.warning(module.range, "this ']' closes no '[' in " + place,
                          "a branch is opened and closed in the same successor");
        return;
      }
    }
    if (!open.empty()) {
      messages_.warning(open.back(), "this '[' is not closed in " + place,
                        "a branch is opened and closed in the same successor");
    }
  }

  // a polygon may be begun by one production and ended by another
  void checkPolygons() {
    const core::SourceRange* opened = nullptr;
    const core::SourceRange* closed = nullptr;
    forModules([&](const Modules& modules) {
      for (const ModuleSyntax& module : modules) {
        const char character = module.parameters.empty() ? characterOf(module.type) : '\0';
        opened = character == '{' && opened == nullptr ? &module.range : opened;
        closed = character == '}' && closed == nullptr ? &module.range : closed;
      }
    });
    if (opened != nullptr && closed == nullptr) {
      messages_.warning(*opened, "this '{' begins a polygon, and no '}' of the model ends one",
                        "write '}' behind its last point; without it nothing is filled");
    } else if (closed != nullptr && opened == nullptr) {
      messages_.warning(*closed, "this '}' ends a polygon, and no '{' of the model begins one",
                        "write '{' in front of its first point");
    }
  }

  // a successor that goes on in column 1 is read as the predecessor of another production
  void checkContinuation(const ProductionSyntax& production) {
    const char first = characterOf(production.predecessor.front().type);
    if (!isTranslation_ && (first == '[' || first == ']') && production.predecessor.size() > 1) {
      messages_.warning(production.predecessorRange,
                        "'" + textOf(production.predecessorRange) + "' is the predecessor of a production of its own",
                        "to continue the successor of the line above, begin the line with a TAB");
    }
  }

  // ---- productions that are never applied

  static bool sameTypes(const FormalModuleSyntax& a, const FormalModuleSyntax& b) { return a.type == b.type; }
  static bool sameElements(const ContextElementSyntax& a, const ContextElementSyntax& b) {
    return a.kind == b.kind && a.module.type == b.module.type;
  }
  [[nodiscard]] bool isAlwaysTrue(const ProductionSyntax& production) const {
    return production.condition == kNoExpression || valueOf(production.condition).value_or(0.0) != 0.0;
  }
  /// Whether the condition is a number as people write for a probability: 0.5, or 50 for percent.
  [[nodiscard]] bool hasProbabilityAsCondition(const ProductionSyntax& production) const {
    if (production.condition == kNoExpression || isTranslation_) {
      return false;
    }
    const double value = valueOf(production.condition).value_or(1.0);
    const bool isNumber = model_.expressions[production.condition].kind == ExpressionKind::Number;
    return value > 0.0 && (value < 1.0 || (isNumber && value > 1.0));
  }
  void checkProbability(const ProductionSyntax& production) {
    if (hasProbabilityAsCondition(production)) {
      const core::SourceRange range = model_.expressions[production.condition].range;
      messages_.warning(range, "the condition '" + textOf(range) + "' always holds",
                        "a number behind the predecessor is a condition; a probability stands at the end, as in "
                        "A --> AB : 0.5");
    }
  }
  /// Whether `earlier` matches wherever `later` would.
  [[nodiscard]] bool hides(const ProductionSyntax& earlier, const ProductionSyntax& later) const {
    if (!isAlwaysTrue(earlier) || !earlier.newLeftContext.empty() || !earlier.newRightContext.empty() ||
        earlier.predecessor.size() > later.predecessor.size() ||
        earlier.leftContext.size() > later.leftContext.size() ||
        earlier.rightContext.size() > later.rightContext.size() ||
        (!earlier.rightContext.empty() && earlier.predecessor.size() != later.predecessor.size())) {
      return false;
    }
    // the last module of a left context is the nearest
    return std::equal(earlier.predecessor.begin(), earlier.predecessor.end(), later.predecessor.begin(), sameTypes) &&
           std::equal(earlier.leftContext.rbegin(), earlier.leftContext.rend(), later.leftContext.rbegin(),
                      sameElements) &&
           std::equal(earlier.rightContext.begin(), earlier.rightContext.end(), later.rightContext.begin(),
                      sameElements);
  }

  void checkHidden(const ProductionListSyntax& list) {
    std::map<core::ModuleTypeId, std::vector<const ProductionSyntax*>> unconditional;
    for (const ProductionSyntax& production : list.productions) {
      core::pollWork();
      std::vector<const ProductionSyntax*>& earlier = unconditional[production.predecessor.front().type];
      const auto hiding = std::find_if(earlier.begin(), earlier.end(),
                                       [&](const ProductionSyntax* other) { return hides(*other, production); });
      // a probability in the place of the condition has a message of its own
      if (hiding != earlier.end() && !hasProbabilityAsCondition(**hiding)) {
        const core::SourceRange range = (*hiding)->range;
        const std::string text = textOf({range.begin, std::min(range.end, range.begin + 60)});
        messages_.warning(production.predecessorRange,
                          "this production is never applied: an earlier production matches wherever this one would",
                          "the earlier production is: " + text + "; move it behind this one");
      } else if (hiding == earlier.end() && isAlwaysTrue(production)) {
        earlier.push_back(&production);
      }
    }
  }

  // ---- parameters that no production reads

  void collectNames(ExpressionIndex expression, std::set<std::string>& names) const {
    if (expression == kNoExpression) {
      return;
    }
    for (ExpressionIndex i = firstNode(model_, expression); i <= expression; ++i) {
      if (model_.expressions[i].kind == ExpressionKind::Name) {
        names.insert(model_.expressions[i].text);
      }
    }
  }
  void collectNames(const std::vector<Statement>& statements, std::set<std::string>& names) const {
    for (const Statement& statement : statements) {
      collectNames(statement.value, names);
      collectNames(statement.target, names);
      collectNames(statement.body, names);
      collectNames(statement.otherwise, names);
    }
  }
  [[nodiscard]] std::set<std::string> namesRead(const ProductionSyntax& production) const {
    std::set<std::string> names;
    collectNames(production.preBlock.statements, names);
    collectNames(production.postBlock.statements, names);
    collectNames(production.condition, names);
    collectNames(production.probability, names);
    for (const ModuleSyntax& module : production.successor) {
      for (const ExpressionIndex parameter : module.parameters) {
        collectNames(parameter, names);
      }
    }
    return names;
  }

  /// Modules whose parameters the turtle or the environment reads or writes.
  [[nodiscard]] std::set<core::ModuleTypeId> outsideTypes() const {
    std::set<core::ModuleTypeId> types;
    for (core::ModuleTypeId type = 0; type < model_.symbols.types().size(); ++type) {
      const char c = characterOf(type);
      const bool isLetter = c == '\0' || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
      if (!isLetter || (c != '\0' && std::string_view("FfGgEs").find(c) != std::string_view::npos) ||
          model_.symbols[typeOf(type).symbol].isQuery) {
        types.insert(type);
      }
    }
    forModules([&](const Modules& modules) {
      for (std::size_t i = 1; i < modules.size(); ++i) {
        const char before = modules[i - 1].parameters.empty() ? characterOf(modules[i - 1].type) : '\0';
        if (before == '@' || before == '?' || before == '~') {
          types.insert(modules[i].type);
        }
      }
    });
    return types;
  }

  void checkUnread() {
    struct Use {
      const FormalModuleSyntax* first = nullptr;
      std::vector<bool> isRead;
    };
    std::map<core::ModuleTypeId, Use> uses;
    for (const LSystemSyntax& system : model_.systems) {
      forLists(system, [&](const ProductionListSyntax& list) {
        for (const ProductionSyntax& production : list.productions) {
          const std::set<std::string> names = namesRead(production);
          forFormals(production, [&](const FormalModuleSyntax& module) {
            Use& use = uses[module.type];
            use.first = use.first == nullptr && !isDrawing(system, list) ? &module : use.first;
            use.isRead.resize(module.parameters.size(), false);
            for (std::size_t i = 0; i < module.parameters.size(); ++i) {
              use.isRead[i] = use.isRead[i] || names.contains(module.parameters[i].text);
            }
          });
        }
      });
    }
    const std::set<core::ModuleTypeId> outside = outsideTypes();
    for (const auto& [type, use] : uses) {
      // a parameter that is read shows that the module's values matter
      if (use.first == nullptr || outside.contains(type) ||
          std::find(use.isRead.begin(), use.isRead.end(), true) == use.isRead.end()) {
        continue;
      }
      for (std::size_t i = 0; i < use.isRead.size(); ++i) {
        if (!use.isRead[i]) {
          const NameSyntax& parameter = use.first->parameters[i];
          messages_.warning(parameter.range,
                            "no production reads the parameter '" + parameter.text + "' of " + textOf(use.first->range),
                            "use it or remove it");
        }
      }
    }
  }

  // ---- weights

  void checkWeights(const ProductionListSyntax& list) {
    std::map<std::vector<core::ModuleTypeId>, std::vector<const ProductionSyntax*>> groups;
    for (const ProductionSyntax& production : list.productions) {
      std::vector<core::ModuleTypeId> key;
      for (const FormalModuleSyntax& module : production.predecessor) {
        key.push_back(module.type);
      }
      groups[key].push_back(&production);
      if (production.probability != kNoExpression && valueOf(production.probability).value_or(0.0) < 0.0) {
        messages_.warning(model_.expressions[production.probability].range, "this weight is negative",
                          "weights are 0 (never) or greater; only their ratios count");
      }
    }
    for (const auto& [key, productions] : groups) {
      const bool areZero = std::all_of(productions.begin(), productions.end(), [&](const ProductionSyntax* production) {
        return production->probability != kNoExpression && valueOf(production->probability) == 0.0;
      });
      if (areZero) {
        const ProductionSyntax& first = *productions.front();
        messages_.warning(model_.expressions[first.probability].range,
                          "the weights of all productions of " + textOf(first.predecessorRange) + " are 0",
                          "the first production that matches is always applied; give at least one a weight above 0");
      }
    }
  }

  // ---- L-systems and their calls

  static std::int64_t labelOf(const LSystemSyntax& system) {
    const double value = std::strtod(system.label.c_str(), nullptr);
    return value > -9.0e15 && value < 9.0e15 ? static_cast<std::int64_t>(value) : 0;
  }

  void checkSubSystems() {
    std::set<std::int64_t> labels;
    std::string list;
    for (const LSystemSyntax& system : model_.systems) {
      list += (list.empty() ? "" : ", ") + std::to_string(labelOf(system));
      if (!labels.insert(labelOf(system)).second) {
        messages_.warning(
            system.labelRange, "the label " + system.label + " is used twice",
            "?(" + system.label + ") calls the first L-system of that label; give this one another number");
      }
    }
    std::set<std::int64_t> called;
    bool hasComputedCalls = false;
    forModules([&](const Modules& modules) {
      for (const ModuleSyntax& module : modules) {
        if (characterOf(module.type) != '?' || module.parameters.empty()) {
          continue;
        }
        const std::optional<double> id = valueOf(module.parameters.front());
        hasComputedCalls = hasComputedCalls || !id.has_value();
        if (id.has_value() && *id > -9.0e15 && *id < 9.0e15) {
          const auto label = static_cast<std::int64_t>(*id);
          called.insert(label);
          if (!labels.contains(label)) {
            messages_.warning(module.range, "there is no L-system " + std::to_string(label) + " to call",
                              "the L-systems of this model: " + list);
          }
        }
      }
    });
    for (std::size_t i = 1; i < model_.systems.size() && !hasComputedCalls; ++i) {
      const LSystemSyntax& system = model_.systems[i];
      if (!called.contains(labelOf(system))) {
        messages_.warning(system.labelRange, "the L-system " + system.label + " is never called",
                          "an axiom or successor calls it: ?(" + system.label + ")...$");
      }
    }
  }

  std::string_view text_;
  bool isTranslation_;
  bool beginsElsewhere_;
  const ModelSyntax& model_;
  MessageList& messages_;
  std::vector<std::optional<double>> values_;  // of constant expressions, by index
};

}  // namespace

std::vector<std::string> checkModel(std::string_view text, const CheckedModel& checked, const ModelSyntax& model,
                                    MessageList& messages) {
  return Checks(text, checked, model, messages).run();
}

}  // namespace espalier::language

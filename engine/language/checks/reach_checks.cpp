#include "engine/language/checks/reach_checks.h"

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "engine/language/checks/formal_modules.h"
#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

using Types = std::set<core::ModuleTypeId>;

/// The types of modules that productions can make, beginning with those of the axioms.
class Reach {
 public:
  /// A production that applies when a string contains all modules of `needed`.
  void addRule(const Types& needed, const Types& made) {
    const std::size_t rule = made_.size();
    made_.push_back(made);
    missing_.push_back(needed.size());
    for (const core::ModuleTypeId type : needed) {
      if (reached_.contains(type)) {
        --missing_[rule];
      } else {
        waiting_[type].push_back(rule);
      }
    }
    if (missing_[rule] == 0) {
      add(made);
    }
  }

  void add(const Types& types) {
    std::vector<core::ModuleTypeId> next(types.begin(), types.end());
    while (!next.empty()) {
      const core::ModuleTypeId type = next.back();
      next.pop_back();
      if (!reached_.insert(type).second) {
        continue;
      }
      for (const std::size_t rule : waiting_[type]) {
        if (--missing_[rule] == 0) {
          next.insert(next.end(), made_[rule].begin(), made_[rule].end());
        }
      }
    }
  }

  [[nodiscard]] const Types& reached() const { return reached_; }

 private:
  Types reached_;
  std::vector<Types> made_;                                         // by rule
  std::vector<std::size_t> missing_;                                // by rule: needed types that are not reached
  std::map<core::ModuleTypeId, std::vector<std::size_t>> waiting_;  // rules by a type that they need
};

class ReachChecks {
 public:
  ReachChecks(std::string_view text, bool isTranslation, const ModelSyntax& model, MessageList& messages)
      : text_(text), isTranslation_(isTranslation), model_(model), messages_(messages) {}

  void run() {
    Reach reach;
    reach.add(ofTheEngine());
    for (const LSystemSyntax& system : model_.systems) {
      reach.add(typesOf(system.axiom));
    }
    for (const LSystemSyntax& system : model_.systems) {
      addRules(system.productions, reach);
      addRules(system.decomposition, reach);
    }
    madeByAny_ = typesMade(&LSystemSyntax::productions);
    madeByAny_.merge(typesMade(&LSystemSyntax::decomposition));
    drawn_ = typesMade(&LSystemSyntax::homomorphism);
    reached_ = reach.reached();
    report(reach, {&LSystemSyntax::productions, &LSystemSyntax::decomposition});
    // the homomorphism sees the string and what it makes itself
    for (const LSystemSyntax& system : model_.systems) {
      addRules(system.homomorphism, reach);
    }
    if (!isTranslation_) {
      madeByAny_.merge(drawn_);
      drawn_.clear();
      reached_ = reach.reached();
      report(reach, {&LSystemSyntax::homomorphism});
    }
  }

 private:
  using List = ProductionListSyntax LSystemSyntax::*;

  [[nodiscard]] const Symbol& symbolOf(core::ModuleTypeId type) const {
    return model_.symbols[model_.symbols.types()[type].symbol];
  }

  /// Brackets and cuts: the engine makes %(p,index).
  [[nodiscard]] Types ofTheEngine() const {
    Types types;
    for (core::ModuleTypeId type = 0; type < model_.symbols.types().size(); ++type) {
      const char character = symbolOf(type).character();
      if (character == '[' || character == ']' || character == '%') {
        types.insert(type);
      }
    }
    return types;
  }

  static Types typesOf(const std::vector<ModuleSyntax>& modules) {
    Types types;
    for (const ModuleSyntax& module : modules) {
      types.insert(module.type);
    }
    return types;
  }

  [[nodiscard]] Types typesMade(List list) const {
    Types types;
    for (const LSystemSyntax& system : model_.systems) {
      for (const ProductionSyntax& production : (system.*list).productions) {
        types.merge(typesOf(production.successor));
      }
    }
    return types;
  }

  static void addRules(const ProductionListSyntax& list, Reach& reach) {
    for (const ProductionSyntax& production : list.productions) {
      Types needed;
      forFormals(production, [&](const FormalModuleSyntax& module) { needed.insert(module.type); });
      reach.addRule(needed, typesOf(production.successor));
    }
  }

  /// Whether a production leaves its module as it is: `e --> e` stands where an author wants no production.
  static bool isPlaceholder(const ProductionSyntax& production) {
    return production.predecessor.size() == 1 && production.successor.size() == 1 &&
           production.predecessor[0].type == production.successor[0].type;
  }

  /// Reports the modules of lists that are not reached. What a reported module would make counts as reached, so that
  /// one mistake has one message.
  void report(Reach& reach, const std::vector<List>& lists) {
    // first those that nothing makes: others follow from them
    for (const bool isMadeBySome : {false, true}) {
      for (const LSystemSyntax& system : model_.systems) {
        for (const List list : lists) {
          for (const ProductionSyntax& production : (system.*list).productions) {
            if (production.isLabelled) {
              continue;
            }
            const bool isPlain = !isPlaceholder(production);
            std::vector<const FormalModuleSyntax*> modules;
            forFormals(production, [&](const FormalModuleSyntax& module) {
              if ((isPlain || !isMadeBySome) && madeByAny_.contains(module.type) == isMadeBySome &&
                  !reach.reached().contains(module.type)) {
                modules.push_back(&module);
              }
            });
            for (std::size_t i = 0; i < modules.size(); ++i) {
              if (reach.reached().contains(modules[i]->type)) {
                continue;
              }
              // `?E(x)`: the message is about both
              const bool isQuery = i + 1 < modules.size() && symbolOf(modules[i]->type).character() == '?' &&
                                   modules[i]->range.end == modules[i + 1]->range.begin;
              if (isQuery) {
                reportQuery({modules[i]->range.begin, modules[i + 1]->range.end}, symbolOf(modules[i + 1]->type).name);
                reach.add({modules[i]->type, modules[i + 1]->type});
              } else {
                reportModule(*modules[i]);
                reach.add({modules[i]->type});
              }
            }
          }
        }
      }
    }
  }

  void reportQuery(core::SourceRange range, const std::string& name) {
    const std::string query = foldBlanks(text_.substr(range.begin, range.end - range.begin));
    messages_.warning(
        range, "'" + query + "' never matches: the axiom makes no ?" + name,
        "write '?" + name + "(0)' into the axiom behind the module that asks, as in A(1)?" + name + "(0)");
  }

  void reportModule(const FormalModuleSyntax& module) {
    const core::SymbolId symbol = model_.symbols.types()[module.type].symbol;
    const std::string& name = model_.symbols[symbol].name;
    const std::string begin =
        "'" + foldBlanks(text_.substr(module.range.begin, module.range.end - module.range.begin)) + "' never matches: ";
    std::set<std::uint16_t> arities;
    for (const core::ModuleTypeId type : reached_) {
      if (model_.symbols.types()[type].symbol == symbol) {
        arities.insert(model_.symbols.types()[type].arity);
      }
    }
    const bool isMadeBySome = madeByAny_.contains(module.type);
    if (!arities.empty()) {
      std::string found;
      for (const std::uint16_t arity : arities) {
        found += (found.empty() ? "" : " or ") + (arity == 0 ? std::string("no") : std::to_string(arity));
      }
      messages_.warning(module.range,
                        begin + name + " is only made with " + found +
                            (arities == std::set<std::uint16_t>{1} ? " parameter" : " parameters") +
                            (isMadeBySome ? ", except by productions that never apply" : ""),
                        "a production matches only modules with exactly as many parameters");
    } else if (isMadeBySome) {
      messages_.warning(module.range, begin + "only productions that never apply make the module " + name,
                        "productions begin with the modules of the axiom");
    } else if (drawn_.contains(module.type)) {
      messages_.warning(module.range, begin + "only the homomorphism makes the module " + name,
                        "the homomorphism changes what is drawn, not the string that productions see");
    } else {
      // `A(n) n > 1 --> A(n)`
      const std::size_t sign =
          module.range.begin == 0 ? std::string_view::npos : text_.find_last_not_of(" \t", module.range.begin - 1);
      const bool isCompared =
          sign != std::string_view::npos && (text_[sign] == '<' || text_[sign] == '>') && isDigit(name.front());
      messages_.warning(module.range, begin + "no axiom or successor makes the module " + name,
                        isCompared ? "a condition stands behind a ':', as in A(x) : x > 1 --> B" : "");
    }
  }

  std::string_view text_;
  bool isTranslation_;
  const ModelSyntax& model_;
  MessageList& messages_;
  Types madeByAny_;  // by any production of the lists and those before, also by one that never applies
  Types drawn_;      // only the homomorphism makes them, as far as the lists are concerned
  Types reached_;    // before a message was written
};

}  // namespace

void checkReach(std::string_view text, bool isTranslation, const ModelSyntax& model, MessageList& messages) {
  ReachChecks(text, isTranslation, model, messages).run();
}

}  // namespace espalier::language

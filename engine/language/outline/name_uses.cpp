#include "engine/language/outline/name_uses.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace espalier::language {
namespace {

/// Walks the syntax tree of a model and notes every name with its place in the files.
class NameCollector {
 public:
  explicit NameCollector(const ParsedModel& model) : model_(model.syntax), map_(model.source.sourceMap) {}

  std::vector<NameUse> collect() {
    for (system_ = 0; system_ < model_.systems.size(); ++system_) {
      addSystem(model_.systems[system_]);
    }
    for (const SymbolPlace& place : model_.symbolPlaces) {
      addSymbol(place.symbol, 0, place.range.begin, place.isDeclaration);
    }
    markFirstPlaces();
    return std::move(uses_);
  }

 private:
  void addSystem(const LSystemSyntax& system) {
    externals_.clear();
    for (const NameSyntax& external : system.externals) {
      externals_.insert(external.text);
      add(NameKind::Variable, external.text, 0, external.range);
    }
    for (const ArraySyntax& array : system.arrays) {
      if (NameUse* use = add(NameKind::Array, array.name.text, system_, array.name.range)) {
        use->isDefinition = true;
      }
      addExpressions(array.dimensions);
      addExpressions(array.initial);
    }
    addExpression(system.seed);
    addExpression(system.derivationLength);
    for (const Block* block : {&system.start, &system.startEach, &system.endEach, &system.end}) {
      addStatements(block->statements);
    }
    addModules(system.axiom);
    for (const ProductionListSyntax* list : {&system.productions, &system.decomposition, &system.homomorphism}) {
      addExpression(list->maximumDepth);
      addExpression(list->seed);
      for (const ProductionSyntax& production : list->productions) {
        addProduction(production);
      }
    }
  }

  void addProduction(const ProductionSyntax& production) {
    ++production_;
    addContext(production.newLeftContext);
    addContext(production.leftContext);
    for (const FormalModuleSyntax& module : production.predecessor) {
      addFormal(module, true);
    }
    addContext(production.rightContext);
    addContext(production.newRightContext);
    addStatements(production.preBlock.statements);
    addExpression(production.condition);
    addStatements(production.postBlock.statements);
    addModules(production.successor);
    addExpression(production.probability);
  }

  void addContext(const std::vector<ContextElementSyntax>& elements) {
    for (const ContextElementSyntax& element : elements) {
      if (element.kind == ContextElement::Kind::Module) {
        addFormal(element.module, false);
      }
    }
  }

  void addFormal(const FormalModuleSyntax& module, bool isPredecessor) {
    addModule(module.type, module.range.begin, isPredecessor);
    for (const NameSyntax& parameter : module.parameters) {
      if (NameUse* use = add(NameKind::Parameter, parameter.text, production_, parameter.range)) {
        use->isDefinition = true;
      }
    }
  }

  void addModules(const std::vector<ModuleSyntax>& modules) {
    for (const ModuleSyntax& module : modules) {
      addModule(module.type, module.range.begin, false);
      addExpressions(module.parameters);
    }
  }

  void addModule(core::ModuleTypeId type, std::uint32_t begin, bool isDefinition) {
    if (type != core::kNoModuleType) {
      const ModuleType& module = model_.symbols.types()[type];
      addSymbol(module.symbol, module.arity, begin, isDefinition);
    }
  }

  void addSymbol(core::SymbolId symbol, std::uint32_t arity, std::uint32_t begin, bool isDefinition) {
    const Symbol& named = model_.symbols[symbol];
    const auto length = static_cast<std::uint32_t>(named.name.size());
    if (NameUse* use = add(NameKind::Module, named.name, 0, {begin, begin + length})) {
      use->arity = arity;
      use->isDefinition = isDefinition;
      use->isDeclared = named.isDeclared;
    }
  }

  void addStatements(const std::vector<Statement>& statements) {
    for (const Statement& statement : statements) {
      addExpression(statement.target);
      addExpression(statement.value);
      addStatements(statement.body);
      addStatements(statement.otherwise);
    }
  }

  void addExpressions(const std::vector<ExpressionIndex>& expressions) {
    for (const ExpressionIndex expression : expressions) {
      addExpression(expression);
    }
  }

  void addExpression(ExpressionIndex expression) {
    std::vector<ExpressionIndex> open;
    if (expression != kNoExpression) {
      open.push_back(expression);
    }
    while (!open.empty()) {
      const ExpressionNode& node = model_.expressions[open.back()];
      open.pop_back();
      if (node.kind == ExpressionKind::Name || node.kind == ExpressionKind::Element) {
        addName(node);
      } else if (node.kind == ExpressionKind::Call) {
        add(NameKind::Function, node.text, 0, node.nameRange);
      }
      open.insert(open.end(), node.children.rbegin(), node.children.rend());
    }
  }

  void addName(const ExpressionNode& node) {
    switch (node.binding.kind) {
      case Binding::Kind::Slot:
        add(NameKind::Parameter, node.text, production_, node.nameRange);
        break;
      case Binding::Kind::Static:
        add(NameKind::LocalVariable, node.text, node.binding.index, node.nameRange);
        break;
      case Binding::Kind::Variable:
        add(NameKind::Variable, node.text, externals_.contains(node.text) ? 0 : system_, node.nameRange);
        break;
      case Binding::Kind::Array:
        add(NameKind::Array, node.text, system_, node.nameRange);
        break;
      case Binding::Kind::Step:
      case Binding::Kind::Length:
      case Binding::Kind::Pi:
        add(NameKind::Function, node.text, 0, node.nameRange);
        break;
      case Binding::Kind::Unbound:
        add(NameKind::Unknown, node.text, 0, node.nameRange);
        break;
    }
  }

  /// The use, or null when the range lies outside the files.
  NameUse* add(NameKind kind, const std::string& name, std::uint32_t scope, core::SourceRange range) {
    const auto next = std::upper_bound(
        map_.segments.begin(), map_.segments.end(), range.begin,
        [](std::uint32_t begin, const files::SourceMap::Segment& segment) { return begin < segment.outputBegin; });
    if (next == map_.segments.begin() || name.empty()) {
      return nullptr;
    }
    const files::SourceMap::Segment& segment = *(next - 1);
    if (segment.file >= map_.files.size()) {
      return nullptr;
    }
    NameUse& use = uses_.emplace_back();
    use.kind = kind;
    use.name = name;
    use.scope = scope;
    use.file = segment.file;
    use.isExpanded = segment.expansion != files::SourceMap::kNoExpansion;
    use.offset = use.isExpanded ? segment.fileOffset : segment.fileOffset + (range.begin - segment.outputBegin);
    use.length =
        use.isExpanded ? map_.expansions[segment.expansion].useLength : static_cast<std::uint32_t>(name.size());
    return &use;
  }

  // a variable has no declaration: the first place in the text stands for one
  void markFirstPlaces() {
    std::stable_sort(uses_.begin(), uses_.end(), [](const NameUse& a, const NameUse& b) {
      return std::pair(a.file, a.offset) < std::pair(b.file, b.offset);
    });
    std::set<std::pair<std::string, std::pair<NameKind, std::uint32_t>>> seen;
    for (NameUse& use : uses_) {
      const bool isVariable = use.kind == NameKind::Variable || use.kind == NameKind::LocalVariable;
      if (isVariable && seen.insert({use.name, {use.kind, use.scope}}).second) {
        use.isDefinition = true;
      }
    }
  }

  const ModelSyntax& model_;
  const files::SourceMap& map_;
  std::vector<NameUse> uses_;
  std::set<std::string> externals_;  // of the current L-system
  std::uint32_t system_ = 0;
  std::uint32_t production_ = 0;
};

}  // namespace

std::vector<NameUse> nameUses(const ParsedModel& model) {
  std::vector<NameUse> uses = NameCollector(model).collect();
  std::vector<NameUse> macros = macroUses(model.source.sourceMap);
  // a name that a macro brings stands where the macro is used
  uses.insert(uses.end(), std::make_move_iterator(macros.begin()), std::make_move_iterator(macros.end()));
  std::stable_sort(uses.begin(), uses.end(), [](const NameUse& a, const NameUse& b) {
    return std::pair(a.file, a.offset) < std::pair(b.file, b.offset);
  });
  return uses;
}

}  // namespace espalier::language

#include "engine/language/code_generator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/core/work_meter.h"
#include "engine/language/constant_evaluation.h"

namespace espalier::language {
namespace {

// C's atof, as an integer
std::int64_t labelNumber(std::string_view label) {
  for (std::size_t length = label.size(); length > 0; --length) {
    if (const std::optional<double> value = core::parseNumber(label.substr(0, length)); value.has_value()) {
      return std::fabs(*value) < 9.0e15 ? static_cast<std::int64_t>(*value) : 0;
    }
  }
  return 0;
}

void note(bool& isPure, bool& drawsRandom, bool& isOtherwisePure, bool pure, bool draws, bool otherwisePure) {
  isPure = isPure && pure;
  drawsRandom = drawsRandom || draws;
  isOtherwisePure = isOtherwisePure && otherwisePure;
}

}  // namespace

CodeGenerator::CodeGenerator(ModelSyntax& model, std::string_view text, Program& program)
    : model_(model), text_(text), program_(program) {}

void CodeGenerator::generate() {
  values_ = foldConstants(model_, program_.compatibility);
  computeTraits();
  program_.staticNames = model_.staticNames;
  program_.derivationLength = model_.derivationLength;
  // brackets have types in every model
  program_.openBranch = model_.symbols.internType(model_.symbols.internCharacter('['), 0);
  program_.closeBranch = model_.symbols.internType(model_.symbols.internCharacter(']'), 0);
  // the branch that `%(p)` cuts is kept behind `%(p,n)`
  const core::SymbolId cut = model_.symbols.internCharacter('%');
  const std::vector<ModuleType>& types = model_.symbols.types();
  if (std::any_of(types.begin(), types.end(),
                  [&](const ModuleType& type) { return type.symbol == cut && type.arity == 1; })) {
    static_cast<void>(model_.symbols.internType(cut, 2));
  }
  describeTypes();
  for (const LSystemSyntax& system : model_.systems) {
    generateSystem(system);
  }
  program_.staticCount = static_cast<std::uint32_t>(program_.staticNames.size());
}

// ---- symbols and types

void CodeGenerator::describeTypes() {
  program_.symbols = model_.symbols.symbols();
  program_.types = model_.symbols.types();
  for (const ModuleType& type : program_.types) {
    program_.arity.push_back(type.arity);
    program_.symbolOf.push_back(type.symbol);
    const char character = program_.symbols[type.symbol].character();
    program_.hasQueries =
        program_.hasQueries || (character == '?' && type.arity == 0) || (character == '%' && type.arity > 0);
    program_.hasSubSystems = program_.hasSubSystems || (character == '?' && type.arity > 0);
  }
  program_.cut = findCharacterType('%');
  program_.bareQuery = findCharacterType('?');
  program_.subSystemEnd = findCharacterType('$');
}

core::ModuleTypeId CodeGenerator::findCharacterType(char character) const {
  return program_.findType(std::string_view(&character, 1), 0);
}

void CodeGenerator::resolveIgnored(const LSystemSyntax& syntax, LSystem& system) {
  system.isIgnored.assign(program_.symbols.size(), syntax.hasConsider);
  for (const core::SymbolId symbol : syntax.considered) {
    system.isIgnored[symbol] = false;
  }
  for (const core::SymbolId symbol : syntax.ignored) {
    system.isIgnored[symbol] = true;
  }
  system.ignoresBrackets = system.isIgnored[program_.symbolOf[program_.openBranch]] ||
                           system.isIgnored[program_.symbolOf[program_.closeBranch]];
}

// ---- L-systems

void CodeGenerator::generateSystem(const LSystemSyntax& syntax) {
  LSystem system;
  system.label = labelNumber(syntax.label);
  system.name = syntax.label;
  system.isRing = syntax.isRing;
  system.isStochastic = syntax.isStochastic;
  system.seed = syntax.seedValue;
  resolveIgnored(syntax, system);
  system.variables = syntax.variables;
  system.externals = syntax.externalSlots;
  system.arrays = syntax.arrayVariables;
  system.arrayElementCount = syntax.arrayElementCount;
  system.start = generateBlock(syntax.start);
  system.startEach = generateBlock(syntax.startEach);
  system.endEach = generateBlock(syntax.endEach);
  system.end = generateBlock(syntax.end);
  for (const Block* block : {&syntax.start, &syntax.startEach, &syntax.endEach, &syntax.end}) {
    system.blocksDrawRandom = system.blocksDrawRandom || blockDrawsRandom(block->statements);
  }
  generateModules(syntax.axiom, system.axiom, system.axiomExpressions);
  generateList(syntax.productions, system.productions);
  generateList(syntax.decomposition, system.decomposition);
  generateList(syntax.homomorphism, system.homomorphism);
  system.homomorphismSeed = syntax.homomorphism.seedValue;
  for (const ProductionList* list : {&system.productions, &system.decomposition}) {
    for (const Production& production : list->productions) {
      system.isPure = system.isPure && production.isPure;
      program_.hasContexts = program_.hasContexts || !production.leftContext.empty() ||
                             !production.rightContext.empty() || !production.newLeftContext.empty() ||
                             !production.newRightContext.empty();
    }
  }
  program_.systems.push_back(std::move(system));
}

void CodeGenerator::generateList(const ProductionListSyntax& syntax, ProductionList& list) {
  list.maximumDepth = syntax.maximumDepthValue;
  list.warnsAtDepth = syntax.warns.value_or(true);
  for (const ProductionSyntax& production : syntax.productions) {
    list.productions.push_back(generateProduction(production));
    program_.maximumSlots = std::max(program_.maximumSlots, list.productions.back().slotCount);
  }
  indexProductions(list);
}

void CodeGenerator::indexProductions(ProductionList& list) {
  // counting sort by the type of the first predecessor module
  std::vector<std::uint32_t>& begin = list.index.begin;
  begin.assign(program_.types.size() + 1, 0);
  for (const Production& production : list.productions) {
    ++begin[production.predecessor.front().type + 1U];
  }
  for (std::size_t i = 1; i < begin.size(); ++i) {
    begin[i] += begin[i - 1];
  }
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  list.index.production.resize(list.productions.size());
  for (std::uint32_t i = 0; i < list.productions.size(); ++i) {
    list.index.production[next[list.productions[i].predecessor.front().type]++] = i;
  }
}

bool CodeGenerator::blockDrawsRandom(const std::vector<Statement>& statements) const {
  return std::any_of(statements.begin(), statements.end(), [&](const Statement& statement) {
    return traits_[statement.value].drawsRandom ||
           (statement.target != kNoExpression && traits_[statement.target].drawsRandom) ||
           blockDrawsRandom(statement.body) || blockDrawsRandom(statement.otherwise);
  });
}

// ---- productions

std::vector<ContextElement> CodeGenerator::generateContext(const std::vector<ContextElementSyntax>& syntax) {
  std::vector<ContextElement> context;
  for (const ContextElementSyntax& element : syntax) {
    context.push_back({element.kind, {element.module.type, element.module.firstSlot, element.module.range}});
  }
  return context;
}

Production CodeGenerator::generateProduction(const ProductionSyntax& syntax) {
  Production production;
  for (const FormalModuleSyntax& module : syntax.predecessor) {
    production.predecessor.push_back({module.type, module.firstSlot, module.range});
  }
  // left contexts are searched from the predecessor outwards
  production.leftContext = generateContext(syntax.leftContext);
  std::reverse(production.leftContext.begin(), production.leftContext.end());
  production.newLeftContext = generateContext(syntax.newLeftContext);
  std::reverse(production.newLeftContext.begin(), production.newLeftContext.end());
  production.rightContext = generateContext(syntax.rightContext);
  production.newRightContext = generateContext(syntax.newRightContext);
  production.slotCount = syntax.slotCount;

  bool isOtherwisePure = true;
  const auto account = [&](ExpressionIndex index) {
    const Traits& traits = traits_[index];
    note(production.isPure, production.drawsRandom, isOtherwisePure, traits.isPure, traits.drawsRandom,
         traits.isOtherwisePure);
  };
  production.preBlock = generateBlock(syntax.preBlock);
  if (syntax.condition != kNoExpression) {
    production.condition = generateExpression(syntax.condition);
    account(syntax.condition);
  }
  production.postBlock = generateBlock(syntax.postBlock);
  generateModules(syntax.successor, production.successor, production.expressions);
  for (const ModuleSyntax& module : syntax.successor) {
    std::for_each(module.parameters.begin(), module.parameters.end(), account);
  }
  if (syntax.probability != kNoExpression) {
    production.probability = generateExpression(syntax.probability);
    account(syntax.probability);
  }
  if (syntax.preBlock.isPresent || syntax.postBlock.isPresent) {
    production.isPure = false;
    isOtherwisePure = false;
  }
  production.drawsRandom = production.drawsRandom && isOtherwisePure;
  production.range = syntax.range;
  production.text = foldBlanks(text_.substr(syntax.range.begin, syntax.range.end - syntax.range.begin));
  return production;
}

void CodeGenerator::generateModules(const std::vector<ModuleSyntax>& syntax, std::vector<SuccessorModule>& modules,
                                    std::vector<Expression>& expressions) {
  for (const ModuleSyntax& module : syntax) {
    core::pollWork();
    modules.push_back({module.type, static_cast<std::uint32_t>(expressions.size()), module.range});
    for (const ExpressionIndex parameter : module.parameters) {
      expressions.push_back(generateExpression(parameter));
    }
  }
}

}  // namespace espalier::language

#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/core/limits.h"
#include "engine/language/message_list.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Gives every name its meaning: formal parameter, variable of a production or L-system, array, Q, Z or function.
/// Evaluates the constant items (seed, derivation length, maximum depth, array sizes). Reports mistakes and suspicious
/// places. Completes the syntax tree in place.
class Analyser {
 public:
  /// All references must outlive the analyser; `text` is the preprocessed text.
  Analyser(std::string_view text, core::Compatibility compatibility, const core::Limits& limits, ModelSyntax& model,
           MessageList& messages);

  void analyse();

  /// The names of macros: they are suggested for misspelt names. Must outlive the analyser.
  void setMacros(const std::vector<std::string>& names) { macros_ = &names; }

 private:
  class Scope;

  // analyser.cpp
  void analyseSystem(std::size_t index);
  void defineArrays(LSystemSyntax& system, Scope& scope);
  void defineVariables(LSystemSyntax& system, Scope& scope);
  void analyseBlocks(LSystemSyntax& system, Scope& scope);
  void analyseList(ProductionListSyntax& list, Scope& scope, std::string_view name);
  void analyseProduction(ProductionSyntax& production, Scope& scope);
  void bindFormals(ProductionSyntax& production, Scope& scope);
  void evaluateItems(LSystemSyntax& system, bool isMain);
  void collectAssignedInProductions(const LSystemSyntax& system);
  void warnAboutProbabilities(LSystemSyntax& system);
  [[nodiscard]] double constantItem(ExpressionIndex expression, std::string_view name, double least);

  // analyser_expressions.cpp
  void resolveBlock(Block& block, Scope& scope, std::string_view place);
  void resolveStatements(std::vector<Statement>& statements, Scope& scope);
  void resolveModules(const std::vector<ModuleSyntax>& modules, Scope& scope);
  void resolve(ExpressionIndex expression, Scope& scope);
  void resolveName(ExpressionNode& node, Scope& scope);
  void resolveElement(ExpressionNode& node, Scope& scope);
  void resolveCall(ExpressionNode& node, Scope& scope);
  void resolveFileCall(ExpressionNode& node);
  void checkFileName(const ExpressionNode& call);
  bool checkFormat(const ExpressionNode& call, std::size_t formatIndex, bool isScan);
  void resolveFunction(ExpressionNode& node, Scope& scope);
  void resolveWorldName(ExpressionNode& node, Scope& scope);
  void reportUnknownName(const ExpressionNode& node, const Scope& scope);
  void expectArguments(const ExpressionNode& node, std::size_t least, std::size_t most);

  [[nodiscard]] ExpressionNode& at(ExpressionIndex expression) { return model_.expressions[expression]; }
  [[nodiscard]] std::string describePlace() const;

  std::string_view text_;
  core::Compatibility compatibility_;
  const core::Limits& limits_;
  ModelSyntax& model_;
  MessageList& messages_;
  bool hasSteps_ = false;            // Q and Z are defined
  std::string place_;                // the part of the model that holds the current expression, for messages
  core::SourceRange predecessor_;    // of the current production; empty: none
  core::SourceRange reportedLabel_;  // a predecessor that is the label of a production: one warning is enough
  const std::vector<std::string>* macros_ = nullptr;  // names of macros; null: none are known
  std::set<std::string> unknown_;                     // unknown names of the current L-system: never suggested
  std::set<std::string> assignedInProductions_;       // names assigned in the current L-system's productions
  std::vector<std::optional<double>> values_;         // of constant items, by expression (scratch)
};

/// The names that the statements assign, with the targets of fscanf: each once, in the order of the text.
[[nodiscard]] std::vector<NameSyntax> assignedNames(const ModelSyntax& model, const std::vector<Statement>& statements);

/// The names visible at one point of a model: variables and arrays of the L-system; inside a production also its formal
/// parameters and its own variables.
class Analyser::Scope {
 public:
  Scope(LSystemSyntax& system, std::vector<std::string>& statics) : system_(system), statics_(statics) {}

  void beginProduction() { isProduction_ = true; }
  void endProduction() {
    isProduction_ = false;
    production_.clear();
  }
  [[nodiscard]] bool isProduction() const { return isProduction_; }

  /// Adds a formal parameter. When two have the same name, the first one counts.
  void addFormal(const std::string& name, std::uint32_t slot) {
    production_.emplace(name, Binding{Binding::Kind::Slot, slot});
  }
  /// A variable of the innermost table.
  Binding addVariable(const std::string& name);
  /// A variable of the L-system, wherever the place is.
  Binding addShared(const std::string& name);
  void addArray(const std::string& name, std::uint32_t index) {
    lsystem_.emplace(name, Binding{Binding::Kind::Array, index});
  }
  [[nodiscard]] Binding find(const std::string& name) const;
  [[nodiscard]] std::vector<std::string_view> names() const;
  [[nodiscard]] LSystemSyntax& system() { return system_; }

 private:
  LSystemSyntax& system_;
  std::vector<std::string>& statics_;
  std::map<std::string, Binding> lsystem_;
  std::map<std::string, Binding> production_;
  bool isProduction_ = false;
};

}  // namespace espalier::language

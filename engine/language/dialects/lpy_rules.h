#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "engine/language/dialects/lpy_blocks.h"
#include "engine/language/dialects/lpy_expression.h"

namespace espalier::language {

/// Which modules a successor becomes: those of the string, or those of the turtle.
enum class LpyTarget : std::uint8_t { String, Drawing };

/// Translates modules and rules of L-Py to cpfg's productions.
class LpyRules {
 public:
  explicit LpyRules(DialectReport& report);

  LpyScope& scope() { return scope_; }
  LpyDraws& draws() { return draws_; }
  /// Adds the names of `module A, B(x)`.
  void declare(const TextPiece& list);
  /// A name whose modules an interpretation rule draws: they stay in the successors of other interpretation rules.
  void addInterpreted(const std::string& name) { interpreted_.insert(name); }

  /// A string of modules; nothing after an error.
  [[nodiscard]] std::optional<MappedText> modules(const TextPiece& text, const LpyScope& scope, LpyTarget target);
  /// The modules that the block of an axiom produces; nothing after an error.
  [[nodiscard]] std::optional<MappedText> axiom(const std::vector<PythonStatement>& block);
  /// Adds the productions of one rule: a predecessor with contexts, and a successor behind `-->` or a block.
  void addRule(const TextPiece& head, const std::optional<TextPiece>& successor,
               const std::vector<PythonStatement>& block, LpyTarget target, std::vector<MappedText>& productions);
  /// The statements of Start, StartEach, EndEach or End as cpfg's.
  [[nodiscard]] std::string blockText(const std::vector<PythonStatement>& statements, LpyScope& scope,
                                      std::set<std::string>& globals);

  /// The drawing of the modules of the string, behind the interpretation rules.
  void addDrawing(std::vector<MappedText>& drawing) const;
  /// `Module:` of all names of more than one character, or an empty text.
  [[nodiscard]] std::string declarations() const;
  /// Shared variables for random draws; their initial values stand in Start.
  [[nodiscard]] std::string drawVariables() const;

 private:
  struct Path;
  struct Head {
    MappedText text;                      // contexts and predecessor
    std::vector<std::string> conditions;  // of parameters that are constants or have an `if`
  };

  [[nodiscard]] std::optional<std::string> nameAt(std::string_view text) const;
  [[nodiscard]] bool appendModule(MappedText& result, const std::string& name, const std::vector<LpyValue>& parameters,
                                  LpyTarget target, std::size_t offset);
  [[nodiscard]] std::optional<Head> readHead(const TextPiece& head, LpyScope& scope);
  [[nodiscard]] bool readFormals(const TextPiece& modules, LpyScope& scope, Head& head);
  [[nodiscard]] std::optional<std::string> readFormal(const TextPiece& parameter, LpyScope& scope, Head& head);
  void runStatements(const std::vector<PythonStatement>& statements, LpyTarget target, std::vector<Path>& paths);
  void runIf(const std::vector<PythonStatement>& statements, std::size_t& index, LpyTarget target,
             std::vector<Path>& paths);
  void runOne(const PythonStatement& statement, LpyTarget target, Path& path);
  void assign(const PythonAssignment& assignment, Path& path);
  void refuse(const TextPiece& code, const std::string& what);
  [[nodiscard]] bool countRepetition(const TextPiece& loop, std::size_t paths);

  DialectReport& report_;
  LpyScope scope_;
  LpyDraws draws_;
  std::set<std::string> declared_;
  std::set<std::string> used_;                            // names of more than one character
  std::set<std::string> interpreted_;                     // names of predecessors of interpretation rules
  std::map<std::string, std::set<std::size_t>> arities_;  // of the modules in strings, by name
  std::size_t formalCount_ = 0;
  std::size_t repetitions_ = 0;  // of all loops of a rule, once for each way through it
  bool hasFailed_ = false;
};

}  // namespace espalier::language

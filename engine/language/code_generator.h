#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/language/parse/syntax.h"
#include "engine/language/program.h"

namespace espalier::language {

/// Turns an analysed syntax tree without errors into the instructions of a Program: code, constants, strings, symbols,
/// types and L-systems. The compiler adds files, view settings and hash.
class CodeGenerator {
 public:
  /// The generator moves parts out of `model`; both must outlive it. `text` is the preprocessed text.
  CodeGenerator(ModelSyntax& model, std::string_view text, Program& program);

  void generate();

 private:
  /// The inputs and side effects of an expression.
  struct Traits {
    bool isPure = true;           // depends only on formal parameters, Q, Z and constants
    bool drawsRandom = false;     // contains ran, nran, bran or biran
    bool isOtherwisePure = true;  // pure except for the draws
    bool isSimple = true;         // cheap and without warnings: may be evaluated although its value is not needed
  };

  // code_generator.cpp: L-systems and productions
  void generateSystem(const LSystemSyntax& syntax);
  void generateList(const ProductionListSyntax& syntax, ProductionList& list);
  Production generateProduction(const ProductionSyntax& syntax);
  void generateModules(const std::vector<ModuleSyntax>& syntax, std::vector<SuccessorModule>& modules,
                       std::vector<Expression>& expressions);
  [[nodiscard]] static std::vector<ContextElement> generateContext(const std::vector<ContextElementSyntax>& syntax);
  void indexProductions(ProductionList& list);
  void resolveIgnored(const LSystemSyntax& syntax, LSystem& system);
  void describeTypes();
  [[nodiscard]] core::ModuleTypeId findCharacterType(char character) const;
  [[nodiscard]] bool blockDrawsRandom(const std::vector<Statement>& statements) const;

  // code_generator_expressions.cpp: expressions and statements
  void computeTraits();
  [[nodiscard]] Traits traitsOf(const ExpressionNode& node) const;
  Expression generateExpression(ExpressionIndex index);
  CodeRange generateBlock(const Block& block);
  void emitStatements(const std::vector<Statement>& statements);
  void emitStatement(const Statement& statement);
  void emitStore(const ExpressionNode& target);
  void emitExpression(ExpressionIndex index);
  void emitName(const ExpressionNode& node);
  void emitOperators(ExpressionIndex top);
  void emitLogical(const ExpressionNode& node);
  void emitConditional(const ExpressionNode& node);
  void emitCall(const ExpressionNode& node);
  void emitFileScan(const ExpressionNode& node);
  void emitConstant(double value, core::SourceRange range);
  /// Appends an instruction and returns its index. `stackChange` is what it adds to the depth of the stack.
  std::uint32_t emit(Operation operation, std::uint32_t operand, std::size_t count, core::SourceRange range,
                     int stackChange);
  /// Sets the target of the jump at `instruction` to the next instruction.
  void patch(std::uint32_t instruction);
  [[nodiscard]] std::uint32_t here() const { return static_cast<std::uint32_t>(program_.code.size()); }
  std::uint32_t internConstant(double value);
  std::uint32_t internString(const std::string& text);
  std::uint32_t internFile(const std::string& name, const FileMode& mode);
  std::uint32_t addStatic(std::string name);
  [[nodiscard]] const ExpressionNode& at(ExpressionIndex index) const { return model_.expressions[index]; }
  [[nodiscard]] bool isReference() const { return program_.compatibility != core::Compatibility::Espalier; }

  ModelSyntax& model_;
  std::string_view text_;
  Program& program_;
  std::vector<std::optional<double>> values_;             // of constant expressions, by expression
  std::vector<Traits> traits_;                            // by expression
  std::map<std::uint64_t, std::uint32_t> constantIndex_;  // by bit pattern
  std::map<std::string, std::uint32_t> stringIndex_;
  int stackDepth_ = 0;
};

}  // namespace espalier::language

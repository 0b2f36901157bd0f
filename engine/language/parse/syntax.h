#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/identifiers.h"
#include "engine/language/parse/symbol_table.h"
#include "engine/language/program.h"

namespace espalier::language {

/// The syntax tree of a model. The parser makes it, the analyser completes it and the code generator reads it. All
/// expressions are in one array (ModelSyntax::expressions) and refer to each other by index.
using ExpressionIndex = std::uint32_t;
inline constexpr ExpressionIndex kNoExpression = 0xFFFFFFFF;

enum class ExpressionKind : std::uint8_t {
  Number,       // number
  String,       // text
  Name,         // text; binding
  Element,      // text[children...]; binding
  Reference,    // &children[0] in fscanf
  Unary,        // operation children[0]
  Binary,       // children[0] operation children[1]
  Conditional,  // children[0] ? children[1] : children[2]
  Call,         // text(children...); callee
};

/// The meaning of a name; set by the analyser.
struct Binding {
  enum class Kind : std::uint8_t { Unbound, Slot, Static, Variable, Array, Step, Length, Pi };
  Kind kind = Kind::Unbound;
  std::uint32_t index = 0;
};

/// The called function; set by the analyser.
enum class Callee : std::uint8_t { Unknown, Function, Print, FileOpen, FileClose, FileFlush, FilePrint, FileScan };

struct ExpressionNode {
  ExpressionKind kind = ExpressionKind::Number;
  Operation operation = Operation::Constant;  // Unary and Binary
  Callee callee = Callee::Unknown;
  Function function = Function::Sin;
  Binding binding;
  double number = 0.0;
  std::uint32_t depth = 1;    // of the tree below and including this node
  std::uint32_t nesting = 1;  // the same, but the left operands of operators do not count: 1 for a + b + c + d
  std::string text;
  std::vector<ExpressionIndex> children;
  core::SourceRange range;
  core::SourceRange nameRange;  // of the name of Name, Element and Call
};

struct Statement {
  enum class Kind : std::uint8_t { Assign, Evaluate, If, While, DoWhile };
  Kind kind = Kind::Evaluate;
  ExpressionIndex target = kNoExpression;  // Assign: a Name or Element
  ExpressionIndex value = kNoExpression;   // Assign and Evaluate; the condition of the others
  std::vector<Statement> body;
  std::vector<Statement> otherwise;  // If
  core::SourceRange range;
};

struct Block {
  bool isPresent = false;
  std::vector<Statement> statements;
  core::SourceRange range;
};

struct NameSyntax {
  std::string text;
  core::SourceRange range;
};

/// A module with formal parameters.
struct FormalModuleSyntax {
  core::ModuleTypeId type = core::kNoModuleType;
  std::vector<NameSyntax> parameters;
  std::uint16_t firstSlot = 0;  // set by the analyser
  core::SourceRange range;
};

struct ContextElementSyntax {
  ContextElement::Kind kind = ContextElement::Kind::Module;
  FormalModuleSyntax module;
};

/// A module with expressions.
struct ModuleSyntax {
  core::ModuleTypeId type = core::kNoModuleType;
  std::vector<ExpressionIndex> parameters;
  core::SourceRange range;
};

struct ProductionSyntax {
  std::vector<ContextElementSyntax> newLeftContext, leftContext;  // in the order of the text
  std::vector<FormalModuleSyntax> predecessor;
  std::vector<ContextElementSyntax> rightContext, newRightContext;
  Block preBlock, postBlock;
  ExpressionIndex condition = kNoExpression;  // kNoExpression: always
  std::vector<ModuleSyntax> successor;
  ExpressionIndex probability = kNoExpression;
  core::SourceRange predecessorRange;
  core::SourceRange range;
  // set by the analyser
  std::uint16_t slotCount = 0;
  bool usesFileScan = false;
  bool isLabelled = false;  // its label was read as its predecessor: the message is enough
};

struct ProductionListSyntax {
  std::vector<ProductionSyntax> productions;
  std::optional<bool> warns;  // `warnings`, `no warnings`
  ExpressionIndex maximumDepth = kNoExpression;
  ExpressionIndex seed = kNoExpression;  // homomorphism
  // set by the analyser
  std::uint32_t maximumDepthValue = 1;
  std::optional<double> seedValue;
};

struct ArraySyntax {
  NameSyntax name;
  std::vector<ExpressionIndex> dimensions;
  std::vector<ExpressionIndex> initial;
  core::SourceRange range;
};

struct LSystemSyntax {
  std::string label;
  core::SourceRange labelRange;
  core::SourceRange range;
  bool isRing = false;
  ExpressionIndex seed = kNoExpression;
  ExpressionIndex derivationLength = kNoExpression;
  core::SourceRange derivationLengthRange;
  std::vector<core::SymbolId> ignored;
  std::vector<core::SymbolId> considered;
  bool hasConsider = false;
  std::vector<ArraySyntax> arrays;
  std::vector<NameSyntax> externals;
  Block start, startEach, endEach, end;
  std::vector<ModuleSyntax> axiom;
  ProductionListSyntax productions, decomposition, homomorphism;
  // set by the analyser
  std::optional<std::int64_t> seedValue;
  bool isStochastic = false;
  std::vector<std::string> variables;  // L-system variables by slot
  std::vector<std::uint32_t> externalSlots;
  std::vector<ArrayVariable> arrayVariables;
  std::uint32_t arrayElementCount = 0;
};

/// A symbol outside axioms and productions: in `ignore:`, `consider:` or `Module:`.
struct SymbolPlace {
  core::SymbolId symbol = core::kNoSymbol;
  bool isDeclaration = false;
  core::SourceRange range;
};

struct ModelSyntax {
  std::vector<ExpressionNode> expressions;
  std::vector<LSystemSyntax> systems;
  SymbolTable symbols;
  std::vector<SymbolPlace> symbolPlaces;
  // set by the analyser
  std::uint64_t derivationLength = 1;
  std::vector<std::string> staticNames;  // production-local variables of all productions
};

/// The Binary nodes from `top` down the left operands, `top` first. A sum has as many as it has signs, so functions
/// that call themselves for operands walk along this chain instead.
[[nodiscard]] std::vector<ExpressionIndex> operatorChain(const ModelSyntax& model, ExpressionIndex top);

/// The first node of an expression. The nodes of an expression stand side by side, operands before their operators, so
/// all of them lie between this one and the top.
[[nodiscard]] ExpressionIndex firstNode(const ModelSyntax& model, ExpressionIndex top);

/// Source text for a message: runs of blanks and newlines become one blank, none at the ends.
[[nodiscard]] std::string foldBlanks(std::string_view text);

}  // namespace espalier::language

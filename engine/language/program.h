#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/identifiers.h"
#include "engine/core/limits.h"
#include "engine/files/source_map.h"
#include "engine/files/view_settings.h"

namespace espalier::language {

enum class Operation : std::uint8_t {
#define ESPALIER_INSTRUCTION(name, pops, pushes) name,
#include "engine/language/instruction.def"
};

enum class Function : std::uint8_t {
#define ESPALIER_FUNCTION(name, text, least, most, isPure, usage, meaning) name,
#include "engine/language/function.def"
};

struct Instruction {
  Operation operation = Operation::Constant;
  std::uint16_t count = 0;
  std::uint32_t operand = 0;
};

/// Instructions [begin, end) of Program::code. Empty: absent.
struct CodeRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  [[nodiscard]] bool empty() const { return begin == end; }
};

/// An expression, reduced as far as possible before the run.
struct Expression {
  enum class Kind : std::uint8_t {
    Constant,  // `constant`
    Slot,      // the formal parameter frame[slot], unchanged
    Code,      // `code`, which leaves one value on the stack
  };
  Kind kind = Kind::Constant;
  bool isPure = true;  // depends only on formals, Q, Z and constants; draws and changes nothing
  std::uint32_t slot = 0;
  double constant = 0.0;
  CodeRange code;
  core::SourceRange range;
};

/// A module written with formal parameters: parameters bind to frame slots firstSlot, firstSlot + 1, ...
struct FormalModule {
  core::ModuleTypeId type = core::kNoModuleType;
  std::uint16_t firstSlot = 0;
  core::SourceRange range;
};

/// One element of a context.
struct ContextElement {
  enum class Kind : std::uint8_t {
    Module,           // symbol and parameter count must match
    OpenBranch,       // a literal `[` (right context)
    CloseBranch,      // a literal `]` (right context)
    SkipToBranchEnd,  // `=`: advance to the end of the current branch
  };
  Kind kind = Kind::Module;
  FormalModule module;  // for the brackets: their module type without parameters
};

struct SuccessorModule {
  core::ModuleTypeId type = core::kNoModuleType;
  std::uint32_t firstExpression =
      0;  // into Production::expressions or LSystem::axiomExpressions; the arity is the count
  core::SourceRange range;
};

struct Production {
  std::vector<FormalModule> predecessor;        // at least one, contiguous
  std::vector<ContextElement> leftContext;      // nearest first, i.e. reversed from the text
  std::vector<ContextElement> rightContext;     // nearest first
  std::vector<ContextElement> newLeftContext;   // `<<`, nearest first: the string being produced
  std::vector<ContextElement> newRightContext;  // `>>`
  CodeRange preBlock;
  std::optional<Expression> condition;  // nothing: `*` or absent, always true
  CodeRange postBlock;
  std::vector<SuccessorModule> successor;  // empty: `*`
  std::vector<Expression> expressions;     // parameters of the successor, in order
  std::optional<Expression> probability;
  std::uint16_t slotCount = 0;  // frame size
  bool isPure = true;           // no blocks, and every expression is pure: the order of application does not matter
  bool drawsRandom = false;     // contains ran, nran, bran or biran, and is pure otherwise
  core::SourceRange range;      // predecessor to successor
  std::string text;             // as written, each run of blanks as one: for messages
};

/// Productions by the type of their first predecessor module, each list in file order.
struct ProductionIndex {
  std::vector<std::uint32_t> begin;       // (moduleTypeCount + 1)
  std::vector<std::uint32_t> production;  // indices into the list
  [[nodiscard]] std::span<const std::uint32_t> candidates(core::ModuleTypeId type) const {
    return {production.data() + begin[type], production.data() + begin[type + 1U]};
  }
  [[nodiscard]] bool empty() const { return production.empty(); }
};

struct ProductionList {
  std::vector<Production> productions;
  ProductionIndex index;
  std::uint32_t maximumDepth = 1;  // decomposition and homomorphism
  bool warnsAtDepth = true;

  /// Whether a production of the list may apply to modules of the type.
  [[nodiscard]] bool mayApplyTo(core::ModuleTypeId type) const {
    return !index.empty() && maximumDepth > 0 && !index.candidates(type).empty();
  }
};

struct ArrayVariable {
  std::string name;
  std::vector<std::uint32_t> dimensions;  // as declared, row-major
  std::uint32_t firstElement = 0;         // into the instance's array storage
  std::vector<double> initial;            // all elements
};

/// One `Lsystem: ... endlsystem`.
struct LSystem {
  std::int64_t label = 0;
  std::string name;  // the label as written
  bool isRing = false;
  bool isStochastic = false;         // each scanned module makes one draw, and weights count
  std::optional<std::int64_t> seed;  // `seed:` item
  std::vector<bool> isIgnored;       // by symbol: skipped in context search (ignore and consider resolved)
  bool ignoresBrackets = false;      // `[` or `]` is ignored: the right context continues into branches

  std::vector<std::string> variables;    // names of the L-system's variables, by slot
  std::vector<std::uint32_t> externals;  // slots declared `external`
  std::vector<ArrayVariable> arrays;
  std::uint32_t arrayElementCount = 0;
  CodeRange start, startEach, endEach, end;
  bool blocksDrawRandom = false;

  std::vector<SuccessorModule> axiom;
  std::vector<Expression> axiomExpressions;
  ProductionList productions;
  ProductionList decomposition;
  ProductionList homomorphism;
  std::optional<double> homomorphismSeed;

  bool isPure = true;  // every production of `productions` and `decomposition` is pure and draws nothing
};

struct Symbol {
  std::string name;
  bool isDeclared = false;                  // from `Module:`
  bool isQuery = false;                     // declared as `?Name(...)`
  std::vector<std::string> parameterNames;  // of a declared module
  /// The character of a one-character symbol, as the turtle reads it; 0 for longer names.
  [[nodiscard]] char character() const { return name.size() == 1 ? name[0] : '\0'; }
};

struct ModuleType {
  core::SymbolId symbol = core::kNoSymbol;
  std::uint16_t arity = 0;
};

/// How a model opens a file: the letters and the `+` of a mode such as "r", "w", "a", "r+".
struct FileMode {
  bool canRead = false;
  bool canWrite = false;
  bool truncates = false;  // w
  bool appends = false;    // a: every write goes to the end
  bool mustExist = false;  // r

  /// Nothing when the text is not a mode. A `b` or `t` has no effect.
  [[nodiscard]] static std::optional<FileMode> parse(std::string_view text);
  /// Conversion to the operand of an instruction and back.
  [[nodiscard]] std::uint16_t bits() const;
  [[nodiscard]] static FileMode fromBits(std::uint16_t bits);
  [[nodiscard]] std::string text() const;
};

/// A file that a model names in fopen. The compiler has read the files that the model reads, so that a run needs no
/// files and a snapshot contains them.
struct ModelFile {
  static constexpr std::uint32_t kNoSource = 0xFFFFFFFFU;
  std::string name;        // as written: relative to the model's folder
  bool isRead = false;     // some fopen can read it
  bool isWritten = false;  // some fopen can write it
  bool isRefused = false;  // outside the model's folder, or it would overwrite the model's own text: fopen returns 0
  std::uint32_t source = kNoSource;  // its content in Program::sources; kNoSource: the file does not exist
};

/// A compiled model. Const after compile and shared by every plant.
struct Program {
  core::Compatibility compatibility = core::Compatibility::Espalier;
  std::string modelFile;
  std::vector<Symbol> symbols;
  std::vector<ModuleType> types;
  std::vector<std::uint16_t> arity;                     // by type, for the hot path
  std::vector<core::SymbolId> symbolOf;                 // by type
  core::ModuleTypeId openBranch = core::kNoModuleType;  // always interned: `[` and `]` without parameters
  core::ModuleTypeId closeBranch = core::kNoModuleType;
  core::ModuleTypeId cut = core::kNoModuleType;           // `%` without parameters, when the model uses it
  core::ModuleTypeId bareQuery = core::kNoModuleType;     // `?` without parameters, when the model uses it
  core::ModuleTypeId subSystemEnd = core::kNoModuleType;  // `$` without parameters, when the model uses it

  std::vector<LSystem> systems;  // the first is the main one
  std::uint64_t derivationLength = 1;
  bool hasQueries = false;      // a bare `?` or `%(`..`)` occurs in an axiom or production: interpret before each step
  bool hasContexts = false;     // any production or decomposition has a context
  bool hasSubSystems = false;   // `?(id...)` occurs
  bool usesViewVolume = false;  // vvXmin or another function of the view volume is called

  std::vector<Instruction> code;
  std::vector<core::SourceRange> codeRanges;  // by instruction, for messages
  std::vector<double> constants;
  std::vector<std::string> strings;
  std::uint32_t staticCount = 0;  // production-local variables of all productions
  std::vector<std::string> staticNames;
  std::uint32_t maximumStack = 0;  // deepest stack of any code
  std::uint16_t maximumSlots = 0;  // largest frame

  std::vector<std::string> reportedCommands;  // symbols behind a `@` that a warning has named: a run does not repeat it

  std::vector<ModelFile> files;  // named by file functions; the operand of FileOpen is an index

  files::ViewSettings view;
  std::string text;            // preprocessed
  files::SourceMap sourceMap;  // of `text`; holds every file read for it
  /// Every file that was read to make this Program (model, includes, view file and the files that it names), by name. A
  /// snapshot contains them and can therefore be resumed anywhere.
  std::vector<files::SourceMap::File> sources;
  std::vector<std::pair<std::string, std::string>> defines;  // overrides given by the caller
  std::string viewFile;                                      // empty: none
  std::uint64_t hash = 0;                                    // of sources, defines and compatibility

  [[nodiscard]] std::size_t moduleTypeCount() const { return types.size(); }
  /// The type of a symbol with an arity, or kNoModuleType when the model never makes it. O(symbols).
  [[nodiscard]] core::ModuleTypeId findType(std::string_view name, std::uint16_t arity) const;
  [[nodiscard]] std::string_view nameOf(core::ModuleTypeId type) const { return symbols[symbolOf[type]].name; }
};

/// The input of the compiler. Names are given to the FileProvider as they are.
struct CompileInput {
  std::string modelFile;  // `FILE`, or `FILE:ENTRY` when a file of a foreign dialect holds several models
  std::string viewFile;   // empty: the reference's defaults
  std::string dialect;    // of the file (engine/language/dialects); empty: found by its content
  core::Compatibility compatibility = core::Compatibility::Espalier;
  std::vector<std::pair<std::string, std::string>>
      defines;  // like the preprocessor's -DNAME=VALUE; they win over #define
  core::Limits limits;
  bool beginsElsewhere = false;  // the run begins with a string that the caller gives, not with the axiom
};

}  // namespace espalier::language

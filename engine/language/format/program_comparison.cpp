#include "engine/language/format/program_comparison.h"

#include <algorithm>
#include <bit>

namespace espalier::language {
namespace {

// the templates below call all of these
bool same(const Production& a, const Production& b);
bool same(const ArrayVariable& a, const ArrayVariable& b);
bool same(const LSystem& a, const LSystem& b);
bool same(const Symbol& a, const Symbol& b);
bool same(const ModuleType& a, const ModuleType& b);
bool same(const ModelFile& a, const ModelFile& b) {
  return a.name == b.name && a.isRead == b.isRead && a.isWritten == b.isWritten && a.isRefused == b.isRefused;
}

bool same(const Instruction& a, const Instruction& b);

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool same(CodeRange a, CodeRange b) {
  return a.begin == b.begin && a.end == b.end;
}

bool same(const Expression& a, const Expression& b) {
  return a.kind == b.kind && a.isPure == b.isPure && a.slot == b.slot && same(a.constant, b.constant) &&
         same(a.code, b.code);
}

bool same(const FormalModule& a, const FormalModule& b) {
  return a.type == b.type && a.firstSlot == b.firstSlot;
}

bool same(const ContextElement& a, const ContextElement& b) {
  return a.kind == b.kind && same(a.module, b.module);
}

bool same(const SuccessorModule& a, const SuccessorModule& b) {
  return a.type == b.type && a.firstExpression == b.firstExpression;
}

template <typename Value>
bool same(const std::optional<Value>& a, const std::optional<Value>& b) {
  return a.has_value() == b.has_value() && (!a || same(*a, *b));
}

template <typename Value>
bool same(const std::vector<Value>& a, const std::vector<Value>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Value& x, const Value& y) { return same(x, y); });
}

bool same(const Production& a, const Production& b) {
  return same(a.predecessor, b.predecessor) && same(a.leftContext, b.leftContext) &&
         same(a.rightContext, b.rightContext) && same(a.newLeftContext, b.newLeftContext) &&
         same(a.newRightContext, b.newRightContext) && same(a.preBlock, b.preBlock) && same(a.condition, b.condition) &&
         same(a.postBlock, b.postBlock) && same(a.successor, b.successor) && same(a.expressions, b.expressions) &&
         same(a.probability, b.probability) && a.slotCount == b.slotCount && a.isPure == b.isPure &&
         a.drawsRandom == b.drawsRandom;
}

bool same(const ProductionList& a, const ProductionList& b) {
  return same(a.productions, b.productions) && a.index.begin == b.index.begin &&
         a.index.production == b.index.production && a.maximumDepth == b.maximumDepth &&
         a.warnsAtDepth == b.warnsAtDepth;
}

bool same(const ArrayVariable& a, const ArrayVariable& b) {
  return a.name == b.name && a.dimensions == b.dimensions && a.firstElement == b.firstElement &&
         same(a.initial, b.initial);
}

bool same(const LSystem& a, const LSystem& b) {
  return a.label == b.label && a.name == b.name && a.isRing == b.isRing && a.isStochastic == b.isStochastic &&
         a.seed == b.seed && a.isIgnored == b.isIgnored && a.ignoresBrackets == b.ignoresBrackets &&
         a.variables == b.variables && a.externals == b.externals && same(a.arrays, b.arrays) &&
         a.arrayElementCount == b.arrayElementCount && same(a.start, b.start) && same(a.startEach, b.startEach) &&
         same(a.endEach, b.endEach) && same(a.end, b.end) && a.blocksDrawRandom == b.blocksDrawRandom &&
         same(a.axiom, b.axiom) && same(a.axiomExpressions, b.axiomExpressions) && same(a.productions, b.productions) &&
         same(a.decomposition, b.decomposition) && same(a.homomorphism, b.homomorphism) &&
         same(a.homomorphismSeed, b.homomorphismSeed) && a.isPure == b.isPure;
}

bool same(const Symbol& a, const Symbol& b) {
  return a.name == b.name && a.isDeclared == b.isDeclared && a.isQuery == b.isQuery &&
         a.parameterNames == b.parameterNames;
}

bool same(const ModuleType& a, const ModuleType& b) {
  return a.symbol == b.symbol && a.arity == b.arity;
}

bool same(const Instruction& a, const Instruction& b) {
  return a.operation == b.operation && a.count == b.count && a.operand == b.operand;
}

}  // namespace

bool isSameProgram(const Program& first, const Program& second) {
  return first.compatibility == second.compatibility && same(first.symbols, second.symbols) &&
         same(first.types, second.types) && first.openBranch == second.openBranch &&
         first.closeBranch == second.closeBranch && first.cut == second.cut && first.bareQuery == second.bareQuery &&
         first.subSystemEnd == second.subSystemEnd && same(first.systems, second.systems) &&
         first.derivationLength == second.derivationLength && first.hasQueries == second.hasQueries &&
         first.hasContexts == second.hasContexts && first.hasSubSystems == second.hasSubSystems &&
         same(first.files, second.files) && same(first.code, second.code) && same(first.constants, second.constants) &&
         first.strings == second.strings && first.staticCount == second.staticCount &&
         first.staticNames == second.staticNames && first.maximumStack == second.maximumStack &&
         first.maximumSlots == second.maximumSlots;
}

}  // namespace espalier::language

#include "engine/language/format/disassembler.h"

#include <array>

#include "engine/core/message_text.h"
#include "engine/core/number_text.h"
#include "engine/language/arithmetic.h"

namespace espalier::language {
namespace {

constexpr std::array kOperationNames{
#define ESPALIER_INSTRUCTION(name, pops, pushes) #name,
#include "engine/language/instruction.def"
};

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    result += c == '\n' ? "\\n" : c == '\t' ? "\\t" : c == '"' ? "\\\"" : std::string(1, c);
  }
  return result + "\"";
}

class Disassembler {
 public:
  Disassembler(const Program& program, DisassemblyPlaces places) : program_(program), places_(places) {}

  std::string run() {
    for (const LSystem& system : program_.systems) {
      writeSystem(system);
    }
    return std::move(text_);
  }

 private:
  void writeSystem(const LSystem& system) {
    system_ = &system;
    text_ += "L-system " + system.name + "\n";
    writeBlock("start", system.start);
    writeBlock("start each", system.startEach);
    writeBlock("end each", system.endEach);
    writeBlock("end", system.end);
    text_ += "axiom\n";
    writeModules(system.axiom, system.axiomExpressions);
    writeList("production", system.productions);
    writeList("decomposition", system.decomposition);
    writeList("homomorphism", system.homomorphism);
  }

  void writeList(const std::string& name, const ProductionList& list) {
    for (std::size_t i = 0; i < list.productions.size(); ++i) {
      const Production& production = list.productions[i];
      text_ += name + " " + std::to_string(i) + ": " + production.text + "\n";
      writePlace(production.range);
      writeBlock("block before", production.preBlock);
      if (production.condition.has_value()) {
        writeExpression("condition", *production.condition);
      }
      writeBlock("block after", production.postBlock);
      writeModules(production.successor, production.expressions);
      if (production.probability.has_value()) {
        writeExpression("probability", *production.probability);
      }
    }
  }

  /// The place of a production, and its line as it was written.
  void writePlace(core::SourceRange range) {
    if (places_ == DisassemblyPlaces::Shown) {
      const core::SourceLocation place = program_.sourceMap.locate(range);
      text_ += "  # " + core::placeText(place) + ": " + place.lineText + "\n";
    }
  }

  void writeBlock(const std::string& name, CodeRange code) {
    if (!code.empty()) {
      text_ += "  " + name + "\n";
      writeCode(code);
    }
  }

  void writeModules(const std::vector<SuccessorModule>& modules, const std::vector<Expression>& expressions) {
    for (const SuccessorModule& module : modules) {
      text_ += "  module " + std::string(program_.nameOf(module.type)) + "\n";
      for (std::uint32_t i = 0; i < program_.arity[module.type]; ++i) {
        writeExpression("  parameter " + std::to_string(i), expressions[module.firstExpression + i]);
      }
    }
  }

  void writeExpression(const std::string& name, const Expression& expression) {
    text_ += "  " + name;
    switch (expression.kind) {
      case Expression::Kind::Constant:
        text_ += " = " + number(expression.constant) + "\n";
        break;
      case Expression::Kind::Slot:
        text_ += " = slot " + std::to_string(expression.slot) + "\n";
        break;
      case Expression::Kind::Code:
        text_ += expression.isPure ? "\n" : " (impure)\n";
        writeCode(expression.code);
        break;
    }
  }

  void writeCode(CodeRange code) {
    for (std::uint32_t i = code.begin; i < code.end; ++i) {
      const Instruction& instruction = program_.code[i];
      std::string index = std::to_string(i);
      index.insert(0, index.size() < 6 ? 6 - index.size() : 0, ' ');
      text_ += index + "  " + kOperationNames[static_cast<std::size_t>(instruction.operation)] +
               operandText(instruction) + "\n";
    }
  }

  static std::string number(double value) {
    std::string text;
    core::appendNumber(text, value, core::NumberStyle::Shortest);
    return text;
  }

  [[nodiscard]] std::string operandText(const Instruction& instruction) const {
    const std::string operand = " " + std::to_string(instruction.operand);
    const std::string count = " " + std::to_string(instruction.count);
    switch (instruction.operation) {
      case Operation::Constant:
        return " " + number(program_.constants[instruction.operand]);
      case Operation::LoadSlot:
      case Operation::StoreSlot:
      case Operation::Jump:
      case Operation::JumpIfZero:
      case Operation::JumpIfNonZero:
      case Operation::JumpIfOrSkips:
        return operand;
      case Operation::LoadStatic:
      case Operation::StoreStatic:
        return operand + " " + program_.staticNames[instruction.operand];
      case Operation::LoadVariable:
      case Operation::StoreVariable:
        return operand + " " + system_->variables[instruction.operand];
      case Operation::LoadElement:
      case Operation::StoreElement:
        return " " + system_->arrays[instruction.operand].name + count;
      case Operation::Call:
        return " " + std::string(functionInfo(static_cast<Function>(instruction.operand)).name) + count;
      case Operation::Print:
      case Operation::FilePrint:
      case Operation::FileScan:
        return " " + quoted(program_.strings[instruction.operand]) + count;
      case Operation::FileOpen:
        return " " + quoted(program_.files[instruction.operand].name) + " " +
               quoted(FileMode::fromBits(instruction.count).text());
      default:
        return {};
    }
  }

  const Program& program_;
  DisassemblyPlaces places_;
  const LSystem* system_ = nullptr;
  std::string text_;
};

}  // namespace

std::string disassemble(const Program& program, DisassemblyPlaces places) {
  return Disassembler(program, places).run();
}

}  // namespace espalier::language

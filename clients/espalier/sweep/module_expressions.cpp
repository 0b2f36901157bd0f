#include "clients/espalier/sweep/module_expressions.h"

#include <algorithm>
#include <cctype>
#include <set>

#include "engine/core/diagnostic.h"
#include "engine/derivation/system_tables.h"
#include "engine/language/compiler.h"
#include "engine/language/preprocess/preprocessor.h"

namespace espalier::command {
namespace {

// the file of the expressions alone
constexpr const char* kFile = "measures.l";

/// The files of a model, one of them with another text.
class WithFile final : public core::FileProvider {
 public:
  WithFile(core::FileProvider& others, std::string name, std::string text)
      : others_(others), name_(std::move(name)), text_(std::move(text)) {}
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    return name == name_ ? text_ : others_.read(name);
  }
  [[nodiscard]] std::optional<std::string> readInside(const std::string& folder, const std::string& name) override {
    return name == name_ ? text_ : others_.readInside(folder, name);
  }

 private:
  core::FileProvider& others_;
  std::string name_;
  std::string text_;
};

std::vector<std::string> namesIn(const std::string& text) {
  std::vector<std::string> names;
  std::string name;
  for (const char c : text + " ") {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_') {
      name += c;
    } else {
      if (!name.empty() && std::isdigit(static_cast<unsigned char>(name.front())) == 0) {
        names.push_back(name);
      }
      name.clear();
    }
  }
  return names;
}

// whether a text would end the expression, and with it the production
bool leavesExpression(const std::string& text) {
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    depth += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
    if (depth < 0 || text[i] == '\n' || text[i] == '{' || text[i] == '}' || text[i] == '#' ||
        (depth == 0 && text[i] == ',') || text.compare(i, 3, "-->") == 0 || text.compare(i, 3, "-o>") == 0) {
      return true;
    }
  }
  return depth != 0;
}

// an L-system with a production for each expression: its condition is the condition, its successor the value
std::string systemOf(const std::vector<ModuleExpression>& expressions, const language::Program& model, bool isAlone) {
  std::string text = "Lsystem: 987654321\n";
  if (isAlone) {
    text += "derivation length: 1\n";  // as the first of a file
  }
  std::set<std::string> declared;
  for (const ModuleExpression& expression : expressions) {
    if (isAlone && expression.of.symbol.size() > 1 && declared.insert(expression.of.symbol).second) {
      text += "Module: " + expression.of.symbol + "(...)\n";
    }
  }
  const std::vector<std::string>& variables = model.systems.front().variables;
  if (!variables.empty()) {
    text += "Start: {";
    for (const std::string& variable : variables) {
      text += " " + variable + " = 0;";
    }
    text += " }\n";
  }
  text += "Axiom: F(0)\n";
  for (const ModuleExpression& expression : expressions) {
    const std::string symbol = expression.of.symbol.empty() ? "F" : expression.of.text();
    text += symbol + " : " + (expression.where.empty() ? "1" : "(" + expression.where + ")") + " --> F((" +
            (expression.value.empty() ? "1" : expression.value) + "))\n";
  }
  return text + "endlsystem\n";
}

struct Compiled {
  std::shared_ptr<const language::Program> program;
  std::string problem;
};

// `own`: the text of the expressions, in which a warning is a mistake too
Compiled compileText(const language::CompileInput& input, core::FileProvider& files, const std::string& own) {
  const language::CompileResult result = language::compile(input, files);
  for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
    const std::string& line = diagnostic.location.lineText;
    // a warning about the predecessor only says that nothing makes the module
    const bool isOwn =
        !line.empty() && diagnostic.location.column > 1 && own.find("\n" + line + "\n") != std::string::npos;
    if (diagnostic.severity == core::Severity::Error || (isOwn && diagnostic.severity == core::Severity::Warning)) {
      return {nullptr, diagnostic.message + (diagnostic.hint.empty() ? "" : ". Hint: " + diagnostic.hint)};
    }
  }
  return {result.program, result.program ? "" : "the expression does not compile"};
}

Compiled compileAlone(const std::vector<ModuleExpression>& expressions, const language::Program& model,
                      core::Compatibility mode) {
  const std::string own = systemOf(expressions, model, true);
  core::MemoryFileProvider files;
  files.add(kFile, own);
  language::CompileInput input;
  input.modelFile = kFile;
  input.compatibility = mode;
  return compileText(input, files, own);
}

Compiled compileWithModel(const std::vector<ModuleExpression>& expressions, const language::Program& model,
                          const language::CompileInput& input, core::FileProvider& files) {
  const std::string text = files.read(input.modelFile).value_or("");
  const std::string own = systemOf(expressions, model, false);
  WithFile with(files, input.modelFile, text + "\n" + own);
  return compileText(input, with, own);
}

derivation::Evaluator::Options optionsWith(core::MessageSink messages) {
  derivation::Evaluator::Options options;
  options.messages = std::move(messages);
  return options;
}

bool drawsRandom(const language::ProductionList& list) {
  return std::any_of(list.productions.begin(), list.productions.end(),
                     [](const language::Production& production) { return production.drawsRandom; });
}

}  // namespace

Result<ModuleExpressions> ModuleExpressions::compile(std::vector<ModuleExpression> expressions,
                                                     const language::Program& model,
                                                     const language::CompileInput& input, core::FileProvider& files) {
  ModuleExpressions compiled;
  if (expressions.empty()) {
    return compiled;
  }
  const std::vector<std::string> macros =
      language::preprocess({.file = input.modelFile, .macros = {}, .overrides = input.defines, .limits = input.limits},
                           files)
          .macros;
  bool usesMacros = false;
  for (const ModuleExpression& expression : expressions) {
    for (const std::string* text : {&expression.value, &expression.where}) {
      if (leavesExpression(*text)) {
        return problem(expression.place + ": '" + *text + "' is not one expression of the model language");
      }
      for (const std::string& name : namesIn(*text)) {
        usesMacros = usesMacros || std::find(macros.begin(), macros.end(), name) != macros.end();
      }
    }
    compiled.hasCondition_.push_back(!expression.where.empty());
  }
  // most expressions need nothing of the model, and then serve for all its variants
  Compiled made;
  if (!usesMacros) {
    made = compileAlone(expressions, model, input.compatibility);
  }
  if (!made.program) {
    made = compileWithModel(expressions, model, input, files);
    compiled.dependsOnMacros_ = true;
  }
  if (!made.program) {
    // the one that is wrong
    for (const ModuleExpression& expression : expressions) {
      const Compiled alone = compileWithModel({expression}, model, input, files);
      if (!alone.program) {
        return problem(expression.place + ": " + alone.problem);
      }
    }
    return problem(made.problem);
  }
  compiled.system_ = made.program->systems.size() - 1;
  const language::ProductionList& list = made.program->systems[compiled.system_].productions;
  if (list.productions.size() != expressions.size() || drawsRandom(list)) {
    return problem(expressions.front().place + ": a measure is an expression without random numbers");
  }
  compiled.program_ = made.program;
  return compiled;
}

ModuleExpressions::Reader::Reader(const ModuleExpressions& expressions, const language::Program& model,
                                  const derivation::PlantState& plant, core::MessageSink messages)
    : expressions_(&expressions),
      random_(expressions.program_->compatibility, 0),
      evaluator_(*expressions.program_, random_, optionsWith(std::move(messages))),
      frame_(expressions.program_->maximumSlots + std::size_t{1}) {
  const language::Program& program = *expressions.program_;
  state_.step = plant.step;
  state_.derivationLength = plant.derivationLength;
  state_.statics.assign(program.staticCount, 0.0);
  state_.instances.push_back(derivation::makeInstance(program, static_cast<std::uint32_t>(expressions.system_)));
  // variables keep their names, not their places
  const std::vector<std::string>& own = program.systems[expressions.system_].variables;
  const std::vector<std::string>& theirs = model.systems.front().variables;
  for (std::size_t i = 0; i < own.size(); ++i) {
    const auto found = std::find(theirs.begin(), theirs.end(), own[i]);
    if (found != theirs.end()) {
      state_.instances.front().variables[i] =
          plant.instances.front().variables[static_cast<std::size_t>(found - theirs.begin())];
    }
  }
  random_.attach(state_.random);
  evaluator_.attach(state_);
  evaluator_.enter(state_.instances.front());
  evaluator_.setStep(plant.step, plant.step);
}

std::optional<double> ModuleExpressions::Reader::value(std::size_t expression, std::span<const double> parameters) {
  const language::Production& production =
      expressions_->program_->systems[expressions_->system_].productions.productions[expression];
  const std::size_t first = production.predecessor.front().firstSlot;
  std::copy_n(parameters.begin(), std::min(parameters.size(), frame_.size() - first),
              frame_.begin() + static_cast<std::ptrdiff_t>(first));
  if (expressions_->hasCondition_[expression] && production.condition &&
      evaluator_.value(*production.condition, frame_.data()) == 0.0) {
    return std::nullopt;
  }
  return evaluator_.value(production.expressions.front(), frame_.data());
}

}  // namespace espalier::command

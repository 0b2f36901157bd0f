#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "engine/core/work_meter.h"
#include "engine/files/file_name.h"
#include "engine/language/analyser.h"
#include "engine/language/arithmetic.h"
#include "engine/language/decimal_comma.h"
#include "engine/language/parse/foreign_lines.h"
#include "engine/language/program.h"
#include "engine/language/world_names.h"

namespace espalier::language {
namespace {

constexpr std::array kSpecialCalls{
#define ESPALIER_SPECIAL_FUNCTION(callee, text, usage, meaning) std::pair{std::string_view(text), Callee::callee},
#include "engine/language/function.def"
};
constexpr std::size_t kMostArguments = 1000;

/// Names in the order of the text, each once.
struct NameCollection {
  std::vector<NameSyntax> names;
  std::set<std::string_view> known;  // texts in the syntax tree

  void add(const ExpressionNode& node) {
    if (known.insert(node.text).second) {
      names.push_back({node.text, node.range});
    }
  }
};

// the targets of fscanf anywhere in an expression
void collectReferences(const ModelSyntax& model, ExpressionIndex expression, NameCollection& names) {
  if (expression == kNoExpression) {
    return;
  }
  for (ExpressionIndex i = firstNode(model, expression); i <= expression; ++i) {
    const ExpressionNode& node = model.expressions[i];
    if (node.kind == ExpressionKind::Reference && model.expressions[node.children[0]].kind == ExpressionKind::Name) {
      names.add(model.expressions[node.children[0]]);
    }
  }
}

void collectAssigned(const ModelSyntax& model, const std::vector<Statement>& statements, NameCollection& names) {
  for (const Statement& statement : statements) {
    collectReferences(model, statement.value, names);
    if (statement.kind == Statement::Kind::Assign && model.expressions[statement.target].kind == ExpressionKind::Name) {
      names.add(model.expressions[statement.target]);
    }
    collectAssigned(model, statement.body, names);
    collectAssigned(model, statement.otherwise, names);
  }
}

std::string joined(const std::vector<std::string_view>& names) {
  std::string text;
  for (const std::string_view name : names) {
    text += (text.empty() ? "" : ", ") + std::string(name);
  }
  return text;
}

// as it is written: w[0][0]
std::string firstElementOf(const ArrayVariable& array) {
  std::string text = array.name;
  for (std::size_t i = 0; i < array.dimensions.size(); ++i) {
    text += "[0]";
  }
  return text;
}

std::string count(std::size_t least, std::size_t most) {
  const std::string number =
      least == most ? std::to_string(least) : std::to_string(least) + " to " + std::to_string(most);
  return number + (most == 1 ? " argument" : " arguments");
}

}  // namespace

std::vector<NameSyntax> assignedNames(const ModelSyntax& model, const std::vector<Statement>& statements) {
  NameCollection collection;
  collectAssigned(model, statements, collection);
  return std::move(collection.names);
}

// ---- statements

void Analyser::resolveBlock(Block& block, Scope& scope, std::string_view place) {
  place_ = place;
  resolveStatements(block.statements, scope);
}

void Analyser::resolveStatements(std::vector<Statement>& statements, Scope& scope) {
  for (Statement& statement : statements) {
    resolve(statement.value, scope);
    if (statement.kind == Statement::Kind::Assign) {
      resolve(statement.target, scope);
      if (const ExpressionNode& target = at(statement.target); isWorldName(target.text)) {
        messages_.error(target.range, "'" + target.text + "' cannot be assigned: it comes from the world",
                        "give the variable another name");
      }
    }
    resolveStatements(statement.body, scope);
    resolveStatements(statement.otherwise, scope);
  }
}

void Analyser::resolveModules(const std::vector<ModuleSyntax>& modules, Scope& scope) {
  for (const ModuleSyntax& module : modules) {
    for (const ExpressionIndex parameter : module.parameters) {
      // a label's text is a string among the parameters
      if (at(parameter).kind != ExpressionKind::String) {
        resolve(parameter, scope);
      }
    }
  }
}

// ---- expressions

void Analyser::resolve(ExpressionIndex expression, Scope& scope) {
  core::pollWork();
  ExpressionNode& node = at(expression);
  switch (node.kind) {
    case ExpressionKind::Name:
      resolveName(node, scope);
      break;
    case ExpressionKind::Call:
      resolveCall(node, scope);
      break;
    case ExpressionKind::String:
      messages_.error(node.range, "a string has no value in " + describePlace(),
                      "strings are formats and file names: printf(\"x = %g\\n\", x)");
      break;
    case ExpressionKind::Reference:
      messages_.error(node.range, "'&' has a meaning only among the arguments of fscanf");
      break;
    case ExpressionKind::Binary: {
      const std::vector<ExpressionIndex> chain = operatorChain(model_, expression);
      resolve(at(chain.back()).children[0], scope);
      for (std::size_t i = chain.size(); i-- > 0;) {
        resolve(at(chain[i]).children[1], scope);
      }
      break;
    }
    default:
      for (const ExpressionIndex child : node.children) {
        resolve(child, scope);
      }
      if (node.kind == ExpressionKind::Element) {
        resolveElement(node, scope);
      }
      break;
  }
}

void Analyser::resolveName(ExpressionNode& node, Scope& scope) {
  if (isWorldName(node.text)) {
    resolveWorldName(node, scope);
    return;
  }
  node.binding = scope.find(node.text);
  if (node.binding.kind == Binding::Kind::Array) {
    messages_.error(node.range, "the array '" + node.text + "' needs a subscript in " + describePlace(),
                    "write " + firstElementOf(scope.system().arrayVariables[node.binding.index]));
  }
  if (node.binding.kind != Binding::Kind::Unbound) {
    return;
  }
  if (hasSteps_ && node.text == "Q") {
    node.binding.kind = Binding::Kind::Step;
  } else if (hasSteps_ && node.text == "Z") {
    node.binding.kind = Binding::Kind::Length;
  } else if (compatibility_ == core::Compatibility::Espalier && node.text == "pi") {
    node.binding.kind = Binding::Kind::Pi;
  } else {
    reportUnknownName(node, scope);
    node.binding = scope.addVariable(node.text);
  }
}

void Analyser::resolveWorldName(ExpressionNode& node, Scope& scope) {
  node.binding = scope.addShared(node.text);
  if (compatibility_ != core::Compatibility::Espalier) {
    messages_.error(node.range, "'" + node.text + "' is a name of Espalier's own mode",
                    "leave out --compat, or use a #define");
  } else if (!isKnownWorldName(node.text)) {
    std::vector<std::string_view> names(kWorldNames.begin(), kWorldNames.end());
    const std::string_view near = core::nearestName(node.text.substr(kWorldPrefix.size()), names);
    messages_.error(node.range, "the world has no '" + node.text.substr(kWorldPrefix.size()) + "'",
                    (near.empty() ? "" : "did you mean '" + std::string(kWorldPrefix) + std::string(near) + "'? ") +
                        "There are " + joined(names));
  } else if (place_ == "Start" || place_ == "the axiom") {
    messages_.error(node.range, "'" + node.text + "' has no value yet in " + place_,
                    "read it in a production or in StartEach: the weather is that of a step");
  }
}

void Analyser::reportUnknownName(const ExpressionNode& node, const Scope& scope) {
  // a block reads a name that only productions assign: they share the variable
  if (!scope.isProduction() && assignedInProductions_.contains(node.text)) {
    return;
  }
  if (std::string advice = labelAdvice(text_.substr(predecessor_.begin, predecessor_.end - predecessor_.begin));
      !advice.empty()) {
    if (std::exchange(reportedLabel_, predecessor_) != predecessor_) {
      messages_.warning(node.range, "unknown name '" + node.text + "' in " + describePlace() + ": its value is 0",
                        std::move(advice));
    }
    return;
  }
  // once is enough
  if (!unknown_.insert(node.text).second) {
    return;
  }
  // more messages than anybody is shown need no search for near names
  if (unknown_.size() > 4 * core::DiagnosticList::kLimit) {
    messages_.warning(node.range, "unknown name '" + node.text + "' in " + describePlace() + ": its value is 0");
    return;
  }
  std::vector<std::string_view> names = scope.names();
  std::erase_if(names, [&](std::string_view name) { return unknown_.contains(std::string(name)); });
  if (hasSteps_) {
    names.insert(names.end(), {"Q", "Z"});
  }
  std::vector<std::string_view> candidates = names;
  if (macros_ != nullptr) {
    candidates.insert(candidates.end(), macros_->begin(), macros_->end());
  }
  if (std::ranges::find(candidates, std::string_view(node.text)) != candidates.end()) {
    messages_.warning(node.range, "unknown name '" + node.text + "' in " + describePlace() + ": its value is 0",
                      "no #define of '" + node.text +
                          "' counts here: it stands below, takes parameters, or a condition leaves it out");
    return;
  }
  const std::string_view near = core::nearestName(node.text, candidates);
  std::string hint = near.empty() ? "" : "did you mean '" + std::string(near) + "'? ";
  hint += names.empty() ? "no names are visible here" : "names visible here: " + joined(names);
  if (!near.empty()) {
    const std::size_t list = near.size() + 17;
    hint[list] = static_cast<char>(hint[list] - 'a' + 'A');
  }
  messages_.warning(node.range, "unknown name '" + node.text + "' in " + describePlace() + ": its value is 0",
                    std::move(hint));
}

void Analyser::resolveElement(ExpressionNode& node, Scope& scope) {
  node.binding = scope.find(node.text);
  if (node.binding.kind != Binding::Kind::Array) {
    std::vector<std::string_view> arrays;
    for (const ArrayVariable& array : scope.system().arrayVariables) {
      arrays.push_back(array.name);
    }
    const std::string_view near = core::nearestName(node.text, arrays);
    messages_.error(node.nameRange, "unknown array '" + node.text + "' in " + describePlace(),
                    !near.empty()    ? "did you mean '" + std::string(near) + "'?"
                    : arrays.empty() ? "arrays are defined before the axiom: 'define: { array w[5]; }'"
                                     : "arrays: " + joined(arrays));
    return;
  }
  const ArrayVariable& array = scope.system().arrayVariables[node.binding.index];
  const std::size_t dimensions = array.dimensions.size();
  if (node.children.size() != dimensions) {
    messages_.error(node.range,
                    "expected " + std::to_string(dimensions) + (dimensions == 1 ? " subscript" : " subscripts") +
                        " of the array '" + node.text + "', found " + std::to_string(node.children.size()),
                    "write " + firstElementOf(array));
  }
}

// ---- calls

void Analyser::resolveCall(ExpressionNode& node, Scope& scope) {
  const auto special = std::find_if(kSpecialCalls.begin(), kSpecialCalls.end(),
                                    [&](const auto& entry) { return entry.first == node.text; });
  const std::size_t errorsBefore = messages_.errorCount();
  if (special == kSpecialCalls.end()) {
    resolveFunction(node, scope);
  } else {
    node.callee = special->second;
    resolveFileCall(node);
  }
  if (messages_.errorCount() > errorsBefore && special != kSpecialCalls.end()) {
    return;
  }
  // `node` keeps its address: resolving adds no nodes
  for (const ExpressionIndex child : node.children) {
    const ExpressionNode& argument = at(child);
    if (argument.kind == ExpressionKind::Reference && node.callee == Callee::FileScan) {
      resolve(argument.children[0], scope);
    } else if (argument.kind != ExpressionKind::String || node.callee == Callee::Unknown) {
      resolve(child, scope);
    } else if (node.callee == Callee::Function && node.function != Function::Play) {
      resolve(child, scope);
    }
  }
}

void Analyser::expectArguments(const ExpressionNode& node, std::size_t least, std::size_t most) {
  if (node.children.size() >= least && node.children.size() <= most) {
    return;
  }
  messages_.error(
      node.range,
      "expected " + count(least, most) + " of '" + node.text + "', found " + std::to_string(node.children.size()),
      most == 1 ? decimalCommaHint(text_, at(node.children[0]).range.end) : std::string());
}

void Analyser::resolveFunction(ExpressionNode& node, Scope& scope) {
  const std::span<const FunctionInfo> functions = allFunctions();
  const auto found = std::find_if(functions.begin(), functions.end(),
                                  [&](const FunctionInfo& function) { return node.text == function.name; });
  if (found != functions.end()) {
    node.callee = Callee::Function;
    node.function = static_cast<Function>(found - functions.begin());
    expectArguments(node, found->least, found->most);
    return;
  }
  std::vector<std::string_view> names;
  for (const FunctionInfo& function : functions) {
    names.emplace_back(function.name);
  }
  for (const auto& [name, callee] : kSpecialCalls) {
    names.push_back(name);
  }
  // names of other languages
  constexpr std::array<std::pair<std::string_view, std::string_view>, 9> kElsewhere{
      {{"pow", "the power is an operator: x^2"},
       {"abs", "did you mean 'fabs'?"},
       {"ln", "'log' is the natural logarithm"},
       {"log10", "'log' is the natural logarithm: log(x) / log(10)"},
       {"random", "did you mean 'ran'? ran(1) is a random number between 0 and 1"},
       {"rand", "did you mean 'ran'? ran(1) is a random number between 0 and 1"},
       {"round", "did you mean 'trunc'? It rounds to the nearest whole number"},
       {"int", "did you mean 'floor'?"},
       {"fscan", "did you mean 'fscanf'?"}}};
  const std::string_view near = core::nearestName(node.text, names);
  std::string hint = near.empty() ? "functions: " + joined(names) : "did you mean '" + std::string(near) + "'?";
  for (const auto& [name, advice] : kElsewhere) {
    hint = node.text == name ? std::string(advice) : std::move(hint);
  }
  if (scope.find(node.text).kind != Binding::Kind::Unbound) {
    hint = "'" + node.text + "' is a variable; write the multiplication as '" + node.text + " * (...)'";
  }
  if (std::string advice = labelAdvice(text_.substr(predecessor_.begin, predecessor_.end - predecessor_.begin));
      !advice.empty()) {
    reportedLabel_ = predecessor_;
    hint = std::move(advice);
  }
  messages_.error(node.nameRange, "unknown function '" + node.text + "' in " + describePlace(), std::move(hint));
}

void Analyser::resolveFileCall(ExpressionNode& node) {
  const auto isString = [&](std::size_t i) { return at(node.children[i]).kind == ExpressionKind::String; };
  const auto requireString = [&](std::size_t i, std::string_view what) {
    if (!isString(i)) {
      messages_.error(at(node.children[i]).range, "expected " + std::string(what) + " in quotes as argument " +
                                                      std::to_string(i + 1) + " of '" + node.text + "'");
    }
    return isString(i);
  };
  const std::size_t errorsBefore = messages_.errorCount();
  switch (node.callee) {
    case Callee::Print:
      expectArguments(node, 1, kMostArguments);
      break;
    case Callee::FileOpen:
      expectArguments(node, 2, 2);
      break;
    case Callee::FilePrint:
      expectArguments(node, 2, kMostArguments);
      break;
    case Callee::FileScan:
      expectArguments(node, 3, kMostArguments);
      break;
    default:
      expectArguments(node, 1, 1);
      break;
  }
  if (messages_.errorCount() > errorsBefore) {
    return;
  }
  if (node.callee == Callee::Print) {
    (void)(requireString(0, "a format") && checkFormat(node, 0, false));
    return;
  }
  if (node.callee == Callee::FileOpen) {
    if (requireString(0, "a file name") && requireString(1, "a mode such as \"r\" or \"w\"")) {
      checkFileName(node);
    }
    return;
  }
  if (at(node.children[0]).kind != ExpressionKind::Name) {
    messages_.error(at(node.children[0]).range, "expected a variable as the first argument of '" + node.text + "'",
                    "the variable holds the result of fopen: f = fopen(\"name\", \"r\");");
    return;
  }
  if (node.callee == Callee::FilePrint) {
    (void)(requireString(1, "a format") && checkFormat(node, 1, false));
  } else if (node.callee == Callee::FileScan && requireString(1, "a format")) {
    for (std::size_t i = 2; i < node.children.size(); ++i) {
      if (at(node.children[i]).kind != ExpressionKind::Reference) {
        messages_.error(at(node.children[i]).range,
                        "expected a variable with '&' as argument " + std::to_string(i + 1) + " of 'fscanf'",
                        "write fscanf(f, \"%g\", &x)");
      }
    }
    (void)checkFormat(node, 1, true);
  }
}

/// Checks that the mode of fopen exists and that the name stays inside the model's folder. An fopen of another name
/// fails when the model runs.
void Analyser::checkFileName(const ExpressionNode& call) {
  const ExpressionNode& name = at(call.children[0]);
  const ExpressionNode& mode = at(call.children[1]);
  if (!FileMode::parse(mode.text)) {
    messages_.error(
        mode.range, "'fopen' has no mode \"" + mode.text + "\"",
        "\"r\" reads, \"w\" writes a new file, \"a\" adds to its end; \"r+\", \"w+\" and \"a+\" read and write");
    return;
  }
  if (!files::isNameInside(name.text)) {
    const std::string last = name.text.substr(name.text.find_last_of("/\\") + 1);
    messages_.warning(
        name.range, "the file \"" + name.text + "\" is not inside the model's folder: fopen fails and returns 0",
        files::isNameInside(last) ? "put the file beside the model: fopen(\"" + last + "\", \"" + mode.text + "\")"
                                  : "give the name of a file beside the model");
  }
}

/// Checks that the format has one conversion for each number: only numbers are printed and read.
bool Analyser::checkFormat(const ExpressionNode& call, std::size_t formatIndex, bool isScan) {
  const ExpressionNode& format = at(call.children[formatIndex]);
  const std::string& text = format.text;
  std::size_t conversions = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      continue;
    }
    const std::size_t begin = i++;
    bool isSkipped = false;
    while (i < text.size() && std::string_view("0123456789.-+ #lLh*").find(text[i]) != std::string_view::npos) {
      isSkipped = isSkipped || (isScan && text[i] == '*');
      ++i;
    }
    if (i < text.size() && text[i] == '%') {
      continue;
    }
    if (i >= text.size() || std::string_view("diouxXeEfFgGc").find(text[i]) == std::string_view::npos) {
      messages_.error(
          format.range,
          "the conversion '" + text.substr(begin, i + 1 - begin) + "' of '" + call.text + "' does not fit a number",
          "use %g, %f, %e or %d; '%%' prints a percent sign");
      return false;
    }
    conversions += isSkipped ? 0U : 1U;
  }
  const std::size_t arguments = call.children.size() - formatIndex - 1;
  if (conversions != arguments) {
    messages_.warning(format.range, "the format of '" + call.text + "' has " + std::to_string(conversions) +
                                        (conversions == 1 ? " conversion" : " conversions") + " for " +
                                        std::to_string(arguments) + (arguments == 1 ? " value" : " values"));
  }
  return true;
}

}  // namespace espalier::language

#include "clients/espalier/sweep/module_pattern.h"

#include <algorithm>
#include <cctype>

#include "engine/core/diagnostic.h"

namespace espalier::command {
namespace {

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

bool isName(std::string_view text) {
  return !text.empty() && std::isalpha(static_cast<unsigned char>(text.front())) != 0 &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; });
}

}  // namespace

Result<ModulePattern> ModulePattern::read(std::string_view given) {
  std::string_view text = trimmed(given);
  ModulePattern pattern;
  if (text == "*") {
    return pattern;
  }
  // `?E(x)` is the module E(x) behind a `?`
  if (text.size() > 1 && text.front() == '?') {
    text.remove_prefix(1);
  }
  const std::size_t open = text.size() > 1 ? text.find('(', 1) : std::string_view::npos;
  pattern.symbol = trimmed(text.substr(0, open));
  const auto wrong = [given] {
    return problem("'" + std::string(given) +
                   "' is no module: give * for all, A for every A, or A(l,w) with names for its "
                   "parameters");
  };
  if (pattern.symbol.empty() || pattern.symbol.find_first_of(" \t\n") != std::string::npos) {
    return wrong();
  }
  if (open == std::string_view::npos) {
    return pattern;
  }
  if (text.back() != ')') {
    return wrong();
  }
  pattern.hasParameters = true;
  std::string_view rest = text.substr(open + 1, text.size() - open - 2);
  while (true) {
    const std::size_t comma = rest.find(',');
    const std::string name(trimmed(rest.substr(0, comma)));
    if (!isName(name) ||
        std::find(pattern.parameters.begin(), pattern.parameters.end(), name) != pattern.parameters.end()) {
      return wrong();
    }
    pattern.parameters.push_back(name);
    if (comma == std::string_view::npos) {
      return pattern;
    }
    rest.remove_prefix(comma + 1);
  }
}

std::vector<bool> ModulePattern::typesOf(const language::Program& program) const {
  std::vector<bool> types(program.moduleTypeCount());
  for (std::size_t type = 0; type < types.size(); ++type) {
    const auto id = static_cast<core::ModuleTypeId>(type);
    types[type] = symbol.empty() ||
                  (program.nameOf(id) == symbol && (!hasParameters || program.arity[type] == parameters.size()));
  }
  return types;
}

std::string ModulePattern::problemIn(const language::Program& program) const {
  const std::vector<bool> types = typesOf(program);
  if (std::find(types.begin(), types.end(), true) != types.end()) {
    return {};
  }
  std::vector<std::string_view> names;
  std::string arities;
  for (std::size_t type = 0; type < types.size(); ++type) {
    const std::string_view name = program.nameOf(static_cast<core::ModuleTypeId>(type));
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      names.push_back(name);
    }
    if (name == symbol) {
      arities += (arities.empty() ? "" : " or ") + std::to_string(program.arity[type]);
    }
  }
  if (!arities.empty()) {
    return "the module '" + symbol + "' has " + arities + " parameters in the model, and " + text() + " names " +
           std::to_string(parameters.size());
  }
  return "the model has no module '" + symbol + "'. " + core::suggestName(symbol, names);
}

std::string ModulePattern::text() const {
  if (symbol.empty()) {
    return "*";
  }
  std::string result = symbol;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    result += (i == 0 ? "(" : ",") + parameters[i];
  }
  return parameters.empty() ? result : result + ")";
}

}  // namespace espalier::command

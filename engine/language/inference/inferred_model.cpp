#include "engine/language/inference/inferred_model.h"

#include <algorithm>
#include <vector>

namespace espalier::language {
namespace {

using String = std::vector<std::uint16_t>;

bool isIdentity(std::size_t symbol, const String& successor) {
  return successor == String{static_cast<std::uint16_t>(symbol)};
}

std::string textOrEmpty(const StepStrings& steps, const String& string, const char* emptyText) {
  return string.empty() ? emptyText : steps.text(string);
}

}  // namespace

std::string inferredModelText(const StepStrings& steps, const D0lSystem& system, const std::string& comment) {
  std::string result = "/* " + comment +
                       " */\nLsystem: 1\nderivation length: " + std::to_string(steps.strings.size() - 1) +
                       "\nAxiom: " + textOrEmpty(steps, steps.strings.front(), "*") + "\n";
  for (std::size_t symbol = 0; symbol < system.successors.size(); ++symbol) {
    if (const auto& successor = system.successors[symbol]; successor && !isIdentity(symbol, *successor)) {
      result += steps.names[symbol] + " --> " + textOrEmpty(steps, *successor, "*") + "\n";
    }
  }
  return result + "endlsystem\n";
}

std::string inferredProductions(const StepStrings& steps, const D0lSystem& system) {
  std::string result;
  for (std::size_t symbol = 0; symbol < system.successors.size(); ++symbol) {
    if (const auto& successor = system.successors[symbol]; successor && !isIdentity(symbol, *successor)) {
      result += steps.names[symbol] + " → " + textOrEmpty(steps, *successor, "ε") + "\n";
    }
  }
  return result;
}

std::string inferredDifferences(const StepStrings& steps, const std::vector<D0lSystem>& systems) {
  std::string result;
  for (std::size_t symbol = 0; symbol < steps.names.size(); ++symbol) {
    std::vector<std::string> alternatives;
    for (const D0lSystem& system : systems) {
      if (const auto& successor = system.successors[symbol]) {
        const std::string text = textOrEmpty(steps, *successor, "ε");
        if (std::find(alternatives.begin(), alternatives.end(), text) == alternatives.end()) {
          alternatives.push_back(text);
        }
      }
    }
    if (alternatives.size() > 1) {
      result += "  " + steps.names[symbol] + ": " + alternatives.front();
      for (std::size_t i = 1; i < alternatives.size(); ++i) {
        result += ", or " + alternatives[i];
      }
      result += "\n";
    }
  }
  return result;
}

}  // namespace espalier::language

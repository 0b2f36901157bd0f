#include "engine/language/parse/foreign_lines.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

enum class Habit : std::uint8_t { Productions, Drawing, Steps, Angle, Length, Width, Axiom, Symbols };

constexpr std::array<std::pair<std::string_view, Habit>, 40> kHabits{{
    {"production", Habit::Productions},
    {"productions", Habit::Productions},
    {"production rules", Habit::Productions},
    {"rule", Habit::Productions},
    {"rules", Habit::Productions},
    {"interpretation", Habit::Drawing},
    {"interpretation rules", Habit::Drawing},
    {"graphics", Habit::Drawing},
    {"drawing", Habit::Drawing},
    {"step", Habit::Steps},
    {"steps", Habit::Steps},
    {"number of steps", Habit::Steps},
    {"derivation steps", Habit::Steps},
    {"iteration", Habit::Steps},
    {"iterations", Habit::Steps},
    {"generation", Habit::Steps},
    {"generations", Habit::Steps},
    {"depth", Habit::Steps},
    {"order", Habit::Steps},
    {"n", Habit::Steps},
    {"recursion", Habit::Steps},
    {"angle", Habit::Angle},
    {"turn angle", Habit::Angle},
    {"turning angle", Habit::Angle},
    {"angle increment", Habit::Angle},
    {"delta", Habit::Angle},
    {"step size", Habit::Length},
    {"step length", Habit::Length},
    {"length", Habit::Length},
    {"width", Habit::Width},
    {"line width", Habit::Width},
    {"thickness", Habit::Width},
    {"premise", Habit::Axiom},
    {"omega", Habit::Axiom},
    {"initiator", Habit::Axiom},
    {"start string", Habit::Axiom},
    {"variables", Habit::Symbols},
    {"constants", Habit::Symbols},
    {"alphabet", Habit::Symbols},
    {"symbols", Habit::Symbols},
}};

constexpr std::array<std::string_view, 24> kLatex{
    {"\\alpha", "\\beta",   "\\gamma", "\\delta", "\\epsilon",        "\\varepsilon", "\\theta", "\\lambda",
     "\\sigma", "\\varphi", "\\omega", "\\Omega", "\\rightarrow",     "\\Rightarrow", "\\times", "\\cdot",
     "\\ldots", "\\begin",  "\\end",   "\\item",  "\\longrightarrow", "\\quad",       "\\frac",  "\\sqrt"}};

std::string inSmallLetters(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return result;
}

std::string_view withoutBlanks(std::string_view text) {
  text = trimBlanks(text);
  while (!text.empty() && (text.back() == '\r' || isBlank(text.back()))) {
    text.remove_suffix(1);
  }
  return text;
}

bool isPlainNumber(std::string_view text) {
  return !text.empty() && (isDigit(text[0]) || ((text[0] == '.' || text[0] == '-') && text.size() > 1 &&
                                                (isDigit(text[1]) || text[1] == '.')));
}

// the advice for a word with its value, which may be absent
std::string adviceOf(Habit habit, std::string_view value) {
  const auto number = [value](const char* example) {
    const std::size_t end = std::min(value.find_first_not_of("0123456789."), value.size());
    return isPlainNumber(value) && end > 0 ? std::string(value.substr(0, end)) : std::string(example);
  };
  switch (habit) {
    case Habit::Productions:
      return value.empty() ? "the productions follow the axiom without a heading: remove this line" : std::string();
    case Habit::Drawing:
      return value.empty() ? "the productions for the drawing follow the heading 'homomorphism:'" : std::string();
    case Habit::Steps:
      return "the number of steps is written before the axiom, as 'derivation length: " + number("5") + "'";
    case Habit::Angle:
      return "the angle stands in the view file, as 'angle increment: " + number("30") + "', or in each turn, as +(" +
             number("30") + ")";
    case Habit::Length:
      return "the length stands in the module that draws the line, as F(" + number("2") + ")";
    case Habit::Width:
      return "the width stands in the view file, as 'initial line width: " + number("2") + "', or in a module, as !(" +
             number("2") + ")";
    case Habit::Axiom:
      return "the first string is written as 'Axiom: " + std::string(value.empty() ? "F" : value) + "'";
    case Habit::Symbols:
      return "the symbols of a model are not listed: remove this line";
  }
  return {};
}

// `int x = 3;`, `const r = 0.7`, `x = 3`
std::string constantAdvice(std::string_view line) {
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos || equals + 1 == line.size() || line[equals + 1] == '=') {
    return {};
  }
  std::string_view name = withoutBlanks(line.substr(0, equals));
  std::string_view value = withoutBlanks(line.substr(equals + 1));
  if (value.ends_with(';')) {
    value = withoutBlanks(value.substr(0, value.size() - 1));
  }
  const std::size_t gap = name.find_last_of(" \t");
  if (gap != std::string_view::npos) {
    const std::string_view type = withoutBlanks(name.substr(0, gap));
    constexpr std::array<std::string_view, 8> kTypes{
        {"int", "float", "double", "const", "let", "var", "set", "const float"}};
    if (std::ranges::find(kTypes, type) == kTypes.end()) {
      return {};
    }
    name = name.substr(gap + 1);
  } else if (!isPlainNumber(value)) {
    return {};
  }
  if (inSmallLetters(name) == "seed") {
    return "write ':' in place of '=', as in seed: " + std::string(value);
  }
  if (name.empty() || !isIdentifierStart(name[0]) || !std::ranges::all_of(name, isIdentifierPart) || value.empty()) {
    return {};
  }
  const std::string both = std::string(name) + " " + std::string(value);
  return "a constant is written as '#define " + both + "', and a variable as 'Start: { " + std::string(name) + " = " +
         std::string(value) + "; }'";
}

bool startsLikeRemark(std::string_view line) {
  const std::size_t sign = line.starts_with("--") ? 2 : 1;
  const bool isMarked =
      !line.empty() && (sign == 2 || std::string_view(";%'\"!#").find(line[0]) != std::string_view::npos);
  return isMarked && line.size() > sign + 1 && line[sign] == ' ' && isIdentifierStart(line[sign + 1]);
}

}  // namespace

std::string_view latexCommand(std::string_view text) {
  std::size_t end = 1;
  while (end < text.size() && isIdentifierStart(text[end]) && text[end] != '_') {
    ++end;
  }
  const std::string_view command = text.substr(0, std::min(end, text.size()));
  return std::ranges::find(kLatex, command) == kLatex.end() ? std::string_view() : command;
}

std::string latexAdvice(std::string_view command) {
  const std::string name(command);
  if (command == "\\omega" || command == "\\Omega") {
    return "'" + name + "' is how LaTeX writes the letter of the axiom: write 'Axiom: F' with your string";
  }
  if (command.ends_with("arrow")) {
    return "'" + name + "' is how LaTeX writes the arrow: write '-->'";
  }
  if (command == "\\times" || command == "\\cdot") {
    return "'" + name + "' is how LaTeX writes a product: write '*'";
  }
  if (command == "\\delta") {
    return "'" + name +
           "' is how LaTeX writes the letter of the angle, which stands in the view file, as 'angle "
           "increment: 30'";
  }
  if (command == "\\begin" || command == "\\end" || command == "\\item" || command == "\\quad" ||
      command == "\\ldots" || command == "\\frac" || command == "\\sqrt") {
    return "'" + name + "' is a command of LaTeX: remove it";
  }
  return "'" + name + "' is how LaTeX writes a letter: write the name without '\\'";
}

std::string labelAdvice(std::string_view predecessor) {
  std::string_view rest = predecessor;
  const std::string word = inSmallLetters(predecessor);
  const auto found = std::ranges::find_if(kHabits, [&](const auto& habit) { return habit.first == word; });
  if (found != kHabits.end() && found->second == Habit::Drawing) {
    return adviceOf(Habit::Drawing, {});
  }
  if (found != kHabits.end() && found->second == Habit::Productions) {
    return "productions have no labels: remove '" + std::string(predecessor) + ":'";
  }
  for (const std::string_view begin : {"production", "prod", "rule", "p", "r"}) {
    if (word.starts_with(begin)) {
      rest.remove_prefix(begin.size());
      break;
    }
  }
  if (rest.starts_with('_') || rest.starts_with(' ')) {
    rest.remove_prefix(1);
  }
  const bool isLabel = rest.size() < predecessor.size() && !rest.empty() && std::ranges::all_of(rest, isDigit);
  return isLabel ? "productions have no labels: remove '" + std::string(predecessor) + ":'" : std::string();
}

ForeignLine foreignLine(std::string_view whole) {
  const std::string_view line = withoutBlanks(whole);
  const std::string_view command = latexCommand(line);
  if (line.starts_with('\\') && !command.empty()) {
    return {std::string(command), latexAdvice(command), command == "\\omega"};
  }
  if (startsLikeRemark(line)) {
    return {std::string(line.substr(0, line.find(' '))), "a comment is written as /* ... */ or behind //"};
  }
  if (line.starts_with("define ") && line.find('{') == std::string_view::npos) {
    return {"define", "macros start with '#': #define"};
  }
  // the word ends at a colon, at '=', or before a number
  std::size_t end = std::min(line.find_first_of(":="), line.size());
  const bool isMarked = end < line.size();
  if (!isMarked && line.find_first_of("0123456789") != std::string_view::npos) {
    end = line.find_first_of("0123456789");
  }
  const std::string_view word = withoutBlanks(line.substr(0, end));
  const std::string_view value = withoutBlanks(line.substr(std::min(isMarked ? end + 1 : end, line.size())));
  const std::string name = inSmallLetters(word);
  const auto found = std::ranges::find_if(kHabits, [&](const auto& habit) { return habit.first == name; });
  // a word alone may be symbols, and so may letters before digits without a gap
  const bool isAlone = !isMarked && (value.empty() || end == 0 || !isBlank(line[end - 1]));
  if (found != kHabits.end() && (!isAlone || found->second <= Habit::Drawing)) {
    return {std::string(word) + (isMarked && line[end] == ':' ? ":" : ""), adviceOf(found->second, value),
            found->second == Habit::Axiom};
  }
  if (line.starts_with("ω") || line.starts_with("Ω")) {
    return {"ω", adviceOf(Habit::Axiom, value), true};
  }
  return {std::string(withoutBlanks(line.substr(0, line.find('=')))), constantAdvice(line)};
}

}  // namespace espalier::language

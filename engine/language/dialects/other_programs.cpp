#include "engine/language/dialects/other_programs.h"

#include <algorithm>
#include <array>

#include "engine/files/utf8.h"
#include "engine/language/dialects/text_lines.h"

namespace espalier::language {
namespace {

bool holdsWord(std::string_view text, std::string_view word) {
  return text.find(word) != std::string_view::npos;
}

// `module A(float, int);`: parameters with types of C
bool declaresTypedModules(std::string_view text) {
  for (const TextPiece& line : linesOf(text)) {
    const std::string_view code = line.trimmed().text;
    if (!code.starts_with("module ") || !code.ends_with(";")) {
      continue;
    }
    for (const std::string_view type : {"(int", "(float", "(double", "(struct", "(char", "(bool"}) {
      if (holdsWord(code, type)) {
        return true;
      }
    }
  }
  return false;
}

// `Premise: F` or `premise F`, and `Rule 1: A=FA`
bool isHoudini(std::string_view text) {
  bool hasPremise = false;
  bool hasRule = false;
  for (const TextPiece& line : linesOf(text)) {
    const std::string code = lowered(line.trimmed().text);
    hasPremise = hasPremise || code.starts_with("premise:") || code.starts_with("premise ") ||
                 code.starts_with("premise=") || code.starts_with("premise\t");
    hasRule = hasRule || (code.starts_with("rule") && holdsWord(code, "="));
  }
  return hasPremise && hasRule;
}

// `panel name: size`, perhaps behind `target: file`, and items that begin with `type:`
bool isControlPanel(std::string_view start, std::string_view text) {
  const std::size_t line = start.starts_with("target:") ? start.find('\n') : std::string_view::npos;
  const std::string_view head = line == std::string_view::npos ? start : start.substr(line + 1);
  return head.substr(std::min(head.find_first_not_of(" \t\r\n"), head.size())).starts_with("panel name:") &&
         holdsWord(text, "\ntype:");
}

// `let axiom = "F";`, `rules = {"F": "FF"}`: a list of strings in the language of a program; `new LSystem(…)`
bool isProgram(std::string_view text) {
  bool hasAxiom = false;
  bool hasRules = false;
  for (const TextPiece& line : linesOf(text)) {
    const std::string code = lowered(line.trimmed().text);
    const std::size_t equals = code.find('=');
    if (equals == std::string::npos) {
      continue;
    }
    const std::string_view name = std::string_view(code).substr(0, equals);
    const std::string_view value = std::string_view(code).substr(equals + 1);
    if (holdsWord(value, "new lsystem(")) {
      return true;
    }
    const bool isDeclared = name.starts_with("let ") || name.starts_with("var ") || name.starts_with("const ") ||
                            name.starts_with("string ") || name.starts_with("char");
    hasAxiom = hasAxiom || ((holdsWord(name, "axiom") || holdsWord(name, "sentence") || holdsWord(name, "start")) &&
                            (isDeclared || value.find_first_of("\"'") != std::string_view::npos));
    hasRules = hasRules || (holdsWord(name, "rule") && value.find_first_of("[{") != std::string_view::npos) ||
               (holdsWord(name, "rule") && holdsWord(value, "new "));
  }
  return hasAxiom && hasRules;
}

}  // namespace

ForeignFile fileWithoutText(std::string_view bytes) {
  const std::string kind = files::kindOfNoText(bytes);
  if (kind.empty()) {
    return {};
  }
  if (kind.find("UTF-16") != std::string::npos) {
    return {"this is " + kind, "save it as UTF-8"};
  }
  return {"this is " + kind + ", not a model", "give the name of a text file with an L-system"};
}

ForeignFile modelOfOtherProgram(std::string_view text) {
  const std::size_t first = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  const std::string start = lowered(text.substr(first, 200));
  if (start.starts_with("<!doctype") || start.starts_with("<html") || start.starts_with("<?xml") ||
      start.starts_with("<svg")) {
    return {"this is a web page or another XML file, not a model",
            "save the file itself from the page, or copy the model's lines into a text file"};
  }
  if (start.starts_with("{\"") || start.starts_with("{\n  \"") || start.starts_with("{\r\n  \"")) {
    return {"this is a JSON file, not a model", "a forest (.json) is a model for 'run'; else give an L-system file"};
  }
  if (isControlPanel(start, text)) {
    return {"this is a control panel, not a model",
            "give the .l file whose numbers it edits; the studio shows the panel above its sliders"};
  }
  const bool hasRules = holdsWord(text, "==>") || holdsWord(text, "::>");
  if (hasRules && (holdsWord(text, "module ") || holdsWord(text, "public void") || holdsWord(text, "Axiom"))) {
    return {"this is an XL model for GroIMP, and Espalier does not read XL",
            "write its rules in the language of docs/language.md: 'A(x) --> F(x)[+A(x/2)]' in place of '==>'",
            std::min(text.find("==>"), text.find("::>")), 3};
  }
  if (holdsWord(text, "lpfgall.h") || (declaresTypedModules(text) && !holdsWord(lowered(text), "lsystem:"))) {
    return {"this is an L+C model for lpfg, and Espalier does not read L+C, which needs a C++ compiler",
            "write its productions in the language of docs/language.md: 'A(n) : n > 0 --> F(n)A(n-1)' in place of "
            "'produce'"};
  }
  if (isHoudini(text)) {
    return {
        "this is an L-system of Houdini, and Espalier does not read its rules",
        "write the premise as 'axiom: A', and 'A(h):h>3=B(h):0.5' as 'A(h) : h>3 -> B(h) : 0.5'. Signs with another "
        "meaning: docs/language.md, 2"};
  }
  if (isProgram(text)) {
    return {"this is a program with an L-system in it, not a model",
            "copy the axiom and the rules into a text file: 'axiom: F', 'F -> F+F', 'angle: 60'"};
  }
  return {};
}

}  // namespace espalier::language

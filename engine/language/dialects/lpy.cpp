#include "engine/language/dialects/lpy.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "engine/language/dialects/lpy_rules.h"

namespace espalier::language {
namespace {

constexpr double kMostDerivationSteps = 1e9;
constexpr std::string_view kWidth = "initial line width: 0.2";  // L-Py's radius of 0.1
constexpr std::string_view kCylinders = "line style: cylinder";

// `production:` and other words before a colon, in small letters and with one blank; empty: none
std::string sectionOf(const TextPiece& code) {
  const std::size_t colon = code.text.find(':');
  std::string word = lowered(code.to(colon).trimmed().text);
  word.erase(std::unique(word.begin(), word.end(), [](char a, char b) { return a == ' ' && b == ' '; }), word.end());
  if (word == "endlsystem") {
    return word;
  }
  if (colon == std::string_view::npos) {
    return {};
  }
  for (const std::string_view name : {"axiom", "derivation length", "production", "decomposition", "interpretation",
                                      "homomorphism", "maximum depth", "ignore", "consider", "lsystem"}) {
    if (word == name) {
      return word;
    }
  }
  return word.starts_with("group ") ? "group" : std::string{};
}

// the place of the arrow outside of parentheses
std::size_t ruleArrow(std::string_view code) {
  int depth = 0;
  for (std::size_t at = 0; at < code.size(); ++at) {
    depth += code[at] == '(' ? 1 : code[at] == ')' ? -1 : 0;
    if (depth == 0 && code.substr(at).starts_with("-->")) {
      return at;
    }
  }
  return std::string_view::npos;
}

// the colon behind the head of a rule with a block
std::size_t ruleColon(std::string_view code) {
  int depth = 0;
  for (std::size_t at = 0; at < code.size(); ++at) {
    depth += code[at] == '(' ? 1 : code[at] == ')' ? -1 : 0;
    if (depth == 0 && code[at] == ':') {
      return at;
    }
  }
  return std::string_view::npos;
}

bool isCallback(const std::string& name) {
  return name == "Start" || name == "StartEach" || name == "EndEach" || name == "End";
}

class LpyReader {
 public:
  LpyReader(std::string_view text, DialectReport& report)
      : text_(text), lines_(pythonLines(text)), report_(report), rules_(report) {}

  CpfgModel read() {
    collectNames();
    for (std::size_t i = 0; i < lines_.size(); i = readItem(i)) {
    }
    finish();
    return std::move(model_);
  }

 private:
  enum class Section : std::uint8_t { Header, Production, Decomposition, Interpretation, End };

  // the lines that belong to the line `i`, which are indented deeper
  [[nodiscard]] std::size_t endOfBlock(std::size_t i) const {
    std::size_t end = i + 1;
    while (end < lines_.size() && lines_[end].indent > lines_[i].indent) {
      ++end;
    }
    return end;
  }

  /// Names that stand before their definitions: functions, variables of the L-system, modules with drawings.
  void collectNames() {
    bool isInterpretation = false;
    readSavedNumbers();
    for (const PythonLine& line : lines_) {
      const auto [word, rest] = firstWord(line.code);
      const std::string section = sectionOf(line.code);
      if (!section.empty()) {
        isInterpretation = section == "interpretation" || section == "homomorphism" ||
                           (isInterpretation && section == "maximum depth");
      }
      if (word == "def") {
        const std::string name = firstWord(rest).first;
        rules_.scope().functions[name] = line.code.offset;
      } else if (word == "global") {
        for (const TextPiece& name : lpyArguments(rest)) {
          rules_.scope().variables.insert(std::string(name.text));
        }
      } else if (word == "module" && line.indent == 0) {
        rules_.declare(rest);
      } else if (isInterpretation && line.indent == 0 && section.empty()) {
        const std::size_t end = std::min(line.code.text.find_first_of("(:- "), line.code.text.size());
        rules_.addInterpreted(std::string(line.code.text.substr(0, end)));
      }
    }
  }

  // `('N', 'Integer', 10, 1, 20)` behind the line of `###`: numbers that the user has set
  void readSavedNumbers() {
    const std::size_t begin = text_.find("\n###");
    if (begin == std::string_view::npos) {
      return;
    }
    for (std::size_t at = text_.find("('", begin); at != std::string_view::npos; at = text_.find("('", at + 1)) {
      const std::size_t close = text_.find(')', at);
      const std::vector<TextPiece> parts = lpyArguments({text_.substr(at + 1, close - at - 1), at + 1});
      if (close == std::string_view::npos || parts.size() < 3 || parts[0].text.size() < 3) {
        continue;
      }
      const std::string_view kind = parts[1].text;
      if (kind == "'Integer'" || kind == "'Float'" || kind == "'Bool'") {
        if (const auto value = translateLpyExpression(parts[2], {}, rules_.draws(), report_)) {
          rules_.scope().values[std::string(parts[0].text.substr(1, parts[0].text.size() - 2))] = *value;
        }
      }
    }
  }

  std::size_t readItem(std::size_t i) {
    const PythonLine& line = lines_[i];
    const auto [word, rest] = firstWord(line.code);
    const std::size_t end = endOfBlock(i);
    const std::string section = sectionOf(line.code);
    if (!section.empty()) {
      readSection(section, line.code, lines_.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                  lines_.begin() + static_cast<std::ptrdiff_t>(end));
      return end;
    }
    if (word == "def") {
      readFunction(rest, i, end);
    } else if (word == "module" || word == "endgroup" || word == "forward") {
      // read already, or without effect
    } else if (word == "import" || word == "from") {
      readImport(line.code, rest);
    } else if (word == "backward") {
      refuse(line.code, "'backward', which rewrites from the end,");
    } else if (section_ == Section::Header || section_ == Section::End) {
      readHeader(i, end);
    } else {
      readRule(i, end);
    }
    return end;
  }

  void readSection(const std::string& section, const TextPiece& code, std::vector<PythonLine>::const_iterator begin,
                   std::vector<PythonLine>::const_iterator end) {
    const std::size_t colon = code.text.find(':');
    TextPiece value = colon == std::string_view::npos ? TextPiece{} : code.from(colon + 1).trimmed();
    if (section == "axiom") {
      axiomBlock_ = axiomStatements(value, begin, end);
    }
    // the value may stand on indented lines
    if (begin != end) {
      const TextPiece& last = (end - 1)->code;
      value.offset = value.empty() ? begin->code.offset : value.offset;
      value.text = text_.substr(value.offset, last.offset + last.text.size() - value.offset);
    }
    if (section == "axiom") {
      axiom_ = value;
    } else if (section == "derivation length") {
      readLength(value);
    } else if (section == "maximum depth") {
      readDepth(value);
    } else if (section == "ignore" || section == "consider") {
      model_.items.push_back(MappedText(section + ": ", code.offset).copy(value.text, value.offset));
    } else if (section == "group") {
      refuse(code, "'group'");
    } else if (section == "production" || section == "decomposition") {
      section_ = section == "production" ? Section::Production : Section::Decomposition;
    } else if (section == "interpretation" || section == "homomorphism") {
      section_ = Section::Interpretation;
    } else if (section == "endlsystem") {
      section_ = Section::End;
    }
  }

  // the statements of an axiom that is a block of Python, as a rule's; empty: it is a string of modules
  std::vector<PythonStatement> axiomStatements(const TextPiece& value, std::vector<PythonLine>::const_iterator begin,
                                               std::vector<PythonLine>::const_iterator end) {
    const auto isStatement = [](const TextPiece& code) {
      const std::string word = firstWord(code).first;
      return word == "produce" || word == "nproduce" || word == "if" || word == "for" || word == "while" ||
             word == "global" || assignmentOf(code);
    };
    if (!value.empty()) {
      return isStatement(value) ? std::vector<PythonStatement>{{value, {}, false}} : std::vector<PythonStatement>{};
    }
    if (begin == end || !isStatement(begin->code)) {
      return {};
    }
    return pythonBlock({begin, end}, 0, static_cast<std::size_t>(end - begin), report_);
  }

  std::optional<double> wholeNumber(const TextPiece& value, const std::string& what) {
    const auto number = translateLpyExpression(value, rules_.scope(), rules_.draws(), report_);
    if (!number) {
      return std::nullopt;
    }
    if (!number->number || *number->number < 0.0 || *number->number > kMostDerivationSteps) {
      report_.error(value.offset, std::max<std::size_t>(1, value.text.size()),
                    "expected a constant whole number while reading '" + what + "'",
                    "give a number, or a constant of the file");
      return std::nullopt;
    }
    return std::floor(*number->number);
  }

  void readLength(const TextPiece& value) {
    if (const auto length = wholeNumber(value, "derivation length")) {
      model_.derivationLength = static_cast<std::uint64_t>(*length);
    }
  }

  void readDepth(const TextPiece& value) {
    if (const auto depth = wholeNumber(value, "maximum depth")) {
      (section_ == Section::Decomposition ? model_.decompositionDepth : model_.drawingDepth) =
          static_cast<std::uint32_t>(*depth);
    }
  }

  void refuse(const TextPiece& code, const std::string& what) {
    report_.error(code.offset, code.text.size(), what + " needs Python", std::string(kNeedsPython));
  }

  void readImport(const TextPiece& code, const TextPiece& rest) {
    const std::string module = firstWord(rest).first;
    if (module == "math" || module == "random" || module == "__future__") {
      return;
    }
    if (module == "openalea") {
      report_.warn(code.offset, code.text.size(), "the import has no effect", "Espalier has the turtle, not PlantGL");
      return;
    }
    refuse(code, "the import of '" + module + "'");
  }

  // constants: assignments, also in `if` with a constant condition
  void readHeader(std::size_t begin, std::size_t end) { readConstants(pythonBlock(lines_, begin, end, report_)); }

  void readConstants(const std::vector<PythonStatement>& statements) {
    LpyScope& scope = rules_.scope();
    for (const PythonStatement& statement : statements) {
      const auto [word, rest] = firstWord(statement.code);
      if (word == "if" || word == "elif" || word == "else") {
        const bool isTried = word == "if" || isChainOpen_;
        const auto condition = word == "else" ? std::optional(lpyConstant(1.0))
                                              : translateLpyExpression(rest, scope, rules_.draws(), report_);
        if (!condition || !condition->number) {
          return;
        }
        const bool isTaken = isTried && *condition->number != 0.0;
        if (isTaken) {
          readConstants(statement.body);
        }
        isChainOpen_ = isTried && !isTaken;
      } else if (const auto assignment = assignmentOf(statement.code); assignment && !statement.isCompound) {
        readConstant(*assignment);
      } else if (word == "extern" || word == "print" || word == "pass") {
        // without effect on the strings
      } else {
        refuse(statement.code, "'" + std::string(statement.code.text.substr(0, 40)) + "'");
      }
    }
  }

  void readConstant(const PythonAssignment& assignment) {
    LpyScope& scope = rules_.scope();
    rules_.draws().areNamed = false;
    auto value = translateLpyExpression(assignment.value, scope, rules_.draws(), report_);
    if (!value) {
      return;
    }
    const auto old = scope.values.find(assignment.name);
    if (assignment.operation != '=' && old != scope.values.end() && old->second.number && value->number) {
      const double a = *old->second.number;
      const double b = *value->number;
      value = lpyConstant(assignment.operation == '+'   ? a + b
                          : assignment.operation == '-' ? a - b
                          : assignment.operation == '*' ? a * b
                                                        : a / b);
    }
    // a number that changes, or that is drawn once, is a variable
    if (scope.variables.contains(assignment.name) || !value->number) {
      start_ += lpyName(assignment.name) + " = " + value->text + "; ";
      scope.variables.insert(assignment.name);
    }
    if (value->number && !scope.variables.contains(assignment.name)) {
      scope.values[assignment.name] = *value;
    }
  }

  void readFunction(const TextPiece& rest, std::size_t i, std::size_t end) {
    const std::string name = firstWord(rest).first;
    if (!isCallback(name)) {
      if (name.starts_with("Start") || name.starts_with("End") || name == "PostDraw") {
        refuse(lines_[i].code, "'" + name + "'");
      }
      return;
    }
    LpyScope scope = rules_.scope();
    std::set<std::string> globals;
    const std::vector<PythonStatement> body = pythonBlock(lines_, i, end, report_);
    const std::string block = body.empty() ? std::string{} : rules_.blockText(body.front().body, scope, globals);
    if (name == "Start") {
      startBlock_ = block;
    } else if (!block.empty()) {
      blocks_.emplace_back(name + ": {" + block + "}", lines_[i].code.offset);
    }
  }

  void readRule(std::size_t i, std::size_t end) {
    const TextPiece& code = lines_[i].code;
    const LpyTarget target = section_ == Section::Interpretation ? LpyTarget::Drawing : LpyTarget::String;
    std::vector<MappedText>& productions = section_ == Section::Production      ? model_.productions
                                           : section_ == Section::Decomposition ? model_.decomposition
                                                                                : model_.drawing;
    const std::size_t arrow = ruleArrow(code.text);
    if (arrow != std::string_view::npos) {
      TextPiece successor = code.from(arrow + 3).trimmed();
      if (end > i + 1) {
        const TextPiece& last = lines_[end - 1].code;
        successor.text = text_.substr(successor.offset, last.offset + last.text.size() - successor.offset);
      }
      checkBrackets(text_, successor.offset, successor.offset + successor.text.size(), "the successor", report_);
      return rules_.addRule(code.to(arrow).trimmed(), successor, {}, target, productions);
    }
    const std::size_t colon = ruleColon(code.text);
    if (colon == std::string_view::npos) {
      report_.error(code.offset, code.text.size(),
                    "expected a rule, found '" + std::string(code.text.substr(0, 40)) + "'",
                    "write 'A(x) --> B(x)', or 'A(x) :' with an indented block behind it");
      return;
    }
    const TextPiece rest = code.from(colon + 1).trimmed();
    const std::vector<PythonStatement> block =
        rest.empty() ? pythonBlock(lines_, i + 1, end, report_) : std::vector<PythonStatement>{{rest, {}, false}};
    rules_.addRule(code.to(colon).trimmed(), std::nullopt, block, target, productions);
  }

  void finish() {
    if (axiom_.empty()) {
      report_.error(0, 1, "the model has no axiom", "write the first string behind 'Axiom:'");
    } else {
      rules_.draws().areNamed = false;
      checkBrackets(text_, axiom_.offset, axiom_.offset + axiom_.text.size(), "the axiom", report_);
      std::optional<MappedText> axiom =
          axiomBlock_.empty() ? rules_.modules(axiom_, rules_.scope(), LpyTarget::String) : rules_.axiom(axiomBlock_);
      if (axiom && axiom->empty()) {
        report_.error(axiom_.offset, std::min(axiom_.text.find('\n'), axiom_.text.size()), "the axiom has no module",
                      axiomBlock_.empty()
                          ? "write the first string behind 'Axiom:'"
                          : "'=' gives a variable its value; a module with a number is written as A(3)");
      }
      model_.axiom = axiom.value_or(MappedText{});
    }
    rules_.addDrawing(model_.drawing);
    const std::string start = start_ + rules_.drawVariables() + " " + startBlock_;
    if (start.find_first_not_of(' ') != std::string::npos) {
      model_.items.insert(model_.items.begin(), MappedText("Start: {" + start + "}", 0));
    }
    for (MappedText& block : blocks_) {
      model_.items.push_back(std::move(block));
    }
    if (const std::string names = rules_.declarations(); !names.empty()) {
      model_.items.insert(model_.items.begin(), MappedText(names, 0));
      model_.needs.emplace_back("module names of more than one character");
    }
    model_.viewCommands.emplace_back(kWidth);
    model_.viewCommands.emplace_back(kCylinders);
    model_.turnsByAngle = true;
    model_.angleDegrees = 60.0;  // L-Py's default
  }

  std::string_view text_;
  std::vector<PythonLine> lines_;
  DialectReport& report_;
  LpyRules rules_;
  CpfgModel model_;
  Section section_ = Section::Header;
  TextPiece axiom_;
  std::vector<PythonStatement> axiomBlock_;  // empty: the axiom is a string of modules
  std::string start_;                        // first values of variables
  std::string startBlock_;                   // of the function Start
  std::vector<MappedText> blocks_;
  bool isChainOpen_ = false;  // an `elif` or `else` of the header may still be taken
};

}  // namespace

bool recognisesLpy(std::string_view text) {
  bool hasAxiom = false;
  bool hasSection = false;
  for (const TextPiece& line : linesOf(text)) {
    const TextPiece code = line.trimmed();
    const std::string section = sectionOf(code);
    const auto [word, rest] = firstWord(code);
    hasAxiom = hasAxiom || section == "axiom";
    hasSection =
        hasSection || section == "production" || section == "interpretation" || word == "produce" || word == "nproduce";
  }
  return hasAxiom && hasSection && text.find("→") == std::string_view::npos;
}

CpfgModel translateLpy(std::string_view text, const std::string& /*entry*/, DialectReport& report) {
  return LpyReader(text, report).read();
}

}  // namespace espalier::language

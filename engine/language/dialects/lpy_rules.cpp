#include "engine/language/dialects/lpy_rules.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

namespace espalier::language {
namespace {

constexpr std::size_t kMostPaths = 500;
constexpr std::size_t kMostLoopRuns = 100000;

// L-Py's names of more than one character; the declared names of the model come first
constexpr std::array<std::string_view, 40> kKnownNames{
    "TurnAround", "RollToVert", "IncWidth", "DecWidth", "SetWidth", "IncColor", "DecColor", "SetColor",
    "MoveTo",     "SetHead",    "Sphere",   "Circle",   "RollL",    "RollR",    "Right",    "Left",
    "Down",       "Up",         "Cut",      "nF",       "@Gc",      "@Ge",      "@Gs",      "@Tp",
    "@Tf",        "@Di",        "@Dd",      "@D",       "@O",       "@o",       "@c",       "@M",
    "@R",         "@v",         "@L",       "?P",       "?H",       "?U",       "?L",       "?E"};

/// Turtle modules that only have another name in cpfg.
constexpr std::array<std::pair<std::string_view, std::string_view>, 14> kSynonyms{{{"Left", "+"},
                                                                                   {"Right", "-"},
                                                                                   {"Up", "^"},
                                                                                   {"Down", "&"},
                                                                                   {"RollL", "\\"},
                                                                                   {"RollR", "/"},
                                                                                   {"TurnAround", "|"},
                                                                                   {"RollToVert", "@v"},
                                                                                   {"IncColor", ";"},
                                                                                   {"DecColor", ","},
                                                                                   {"SetColor", ";"},
                                                                                   {"Cut", "%"},
                                                                                   {"@Tp", ""},
                                                                                   {"@L", ""}}};

std::string joined(const std::vector<std::string>& parts, std::string_view separator) {
  std::string text;
  for (const std::string& part : parts) {
    text += (text.empty() ? std::string{} : std::string(separator)) + part;
  }
  return text;
}

std::string called(std::string_view name, const std::vector<std::string>& parameters) {
  return std::string(name) + (parameters.empty() ? "" : "(" + joined(parameters, ",") + ")");
}

/// The cpfg turtle's modules for a module of L-Py; nothing: cpfg's turtle does the same with it. A further parameter
/// marks a result, so that it is not drawn again.
std::optional<std::string> drawingOf(const std::string& name, const std::vector<std::string>& a) {
  for (const auto& [synonym, symbol] : kSynonyms) {
    if (synonym == name) {
      return symbol.empty() ? std::string{} : called(symbol, a);
    }
  }
  const std::size_t count = a.size();
  if (name == "F" && count > 1) {
    return "#(2*" + a[1] + ")F(" + a[0] + ")";
  }
  if (name == "nF" && count > 0) {
    return "F(" + a[0] + ")";
  }
  if ((name == "_" || name == "!" || name == "SetWidth" || name == "IncWidth" || name == "DecWidth") && count > 0) {
    return "#(2*" + a[0] + ")";
  }
  if (name == "_" || name == "IncWidth" || name == "DecWidth") {
    return name == "DecWidth" ? "!" : "#";
  }
  if (name == "Sphere" || name == "Circle" || name == "@O" || name == "@o" || name == "@c") {
    const std::string symbol = name == "Sphere" ? "@O" : name == "Circle" ? "@o" : name;
    return count == 1 ? std::optional(symbol + "(2*" + a[0] + ",0)") : std::nullopt;
  }
  // z is upwards in L-Py and y in Espalier
  if ((name == "@M" || name == "MoveTo") && count == 3) {
    return "@M(" + a[1] + "," + a[2] + "," + a[0] + ",0)";
  }
  if ((name == "@R" || name == "SetHead") && count == 3) {
    return "@R(" + a[1] + "," + a[2] + "," + a[0] + ",0)";
  }
  if ((name == "@R" || name == "SetHead") && count == 6) {
    return "@R(" + a[1] + "," + a[2] + "," + a[0] + "," + a[4] + "," + a[5] + "," + a[3] + ",0)";
  }
  // letters without meaning there
  return name == "G" || name == "g" || name == "#" || name == "$" ? std::optional(std::string{}) : std::nullopt;
}

bool isIdentifier(std::string_view name) {
  return !name.empty() && std::isdigit(static_cast<unsigned char>(name.front())) == 0 &&
         std::all_of(name.begin(), name.end(),
                     [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; });
}

// the place behind the parenthesis that closes the one at `open`
std::size_t behindParenthesis(std::string_view text, std::size_t open) {
  int depth = 0;
  for (std::size_t at = open; at < text.size(); ++at) {
    depth += text[at] == '(' ? 1 : text[at] == ')' ? -1 : 0;
    if (depth == 0) {
      return at + 1;
    }
  }
  return std::string_view::npos;
}

std::string negated(const std::string& condition) {
  return "(!" + condition + ")";
}

}  // namespace

/// One way through a rule's block.
struct LpyRules::Path {
  LpyScope scope;
  std::vector<std::string> conditions;
  std::vector<std::string> assignments;  // to variables of the L-system
  std::set<std::string> globals;
  MappedText successor;
  bool hasSuccessor = false;
  bool isDone = false;  // it has produced
};

LpyRules::LpyRules(DialectReport& report) : report_(report) {}

void LpyRules::declare(const TextPiece& list) {
  for (const TextPiece& piece : lpyArguments(list.to(list.text.find(':')))) {
    const std::string name = std::string(piece.to(piece.text.find('(')).trimmed().text);
    if (!isIdentifier(name)) {
      report_.error(piece.offset, std::max<std::size_t>(1, piece.text.size()), "expected the name of a module",
                    "write 'module Apex, Leaf(size)'");
    } else if (name.size() > 1) {
      declared_.insert(name);
    }
  }
}

std::optional<std::string> LpyRules::nameAt(std::string_view text) const {
  std::string longest(text.substr(0, 1));
  for (const std::string& name : declared_) {
    longest = name.size() > longest.size() && text.starts_with(name) ? name : longest;
  }
  if (longest.size() == 1) {
    for (const std::string_view name : kKnownNames) {
      longest = name.size() > longest.size() && text.starts_with(name) ? std::string(name) : longest;
    }
  }
  const bool isCharacter = static_cast<unsigned char>(longest.front()) > ' ' && longest.front() != 0x7F &&
                           static_cast<unsigned char>(longest.front()) < 0x80 &&
                           std::string_view("<>:*()\"'=").find(longest.front()) == std::string_view::npos;
  return isCharacter ? std::optional(longest) : std::nullopt;
}

bool LpyRules::appendModule(MappedText& result, const std::string& name, const std::vector<LpyValue>& parameters,
                            LpyTarget target, std::size_t offset) {
  std::vector<std::string> texts;
  for (const LpyValue& value : parameters) {
    texts.push_back(value.text);
  }
  if (target == LpyTarget::Drawing && !interpreted_.contains(name)) {
    if (const auto drawing = drawingOf(name, texts)) {
      result.make(*drawing, offset);
      return true;
    }
  }
  if (isIdentifier(name) && name.size() > 1) {
    used_.insert(name);
  }
  arities_[name].insert(parameters.size());
  // two slashes would begin a comment
  const bool isSlash = name == "/" && std::string_view(result.text()).ends_with('/');
  result.make((isSlash ? " " : "") + called(name, texts), offset);
  return true;
}

std::optional<MappedText> LpyRules::modules(const TextPiece& text, const LpyScope& scope, LpyTarget target) {
  MappedText result;
  const TextPiece all = text.trimmed();
  if (all.text == "*") {
    return result;
  }
  for (std::size_t at = 0; at < all.text.size();) {
    const char c = all.text[at];
    const bool isJoint =
        c == '\\' && at + 1 < all.text.size() && (all.text[at + 1] == '\n' || all.text[at + 1] == '\r');
    if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || isJoint) {
      ++at;
      continue;
    }
    const std::size_t offset = all.offset + at;
    const auto name = nameAt(all.text.substr(at));
    if (!name) {
      const std::size_t length = std::min(characterLength(c), all.text.size() - at);
      report_.error(offset, length,
                    "the character '" + std::string(all.text.substr(at, length)) + "' cannot be a module here",
                    c == '(' ? "parameters stand directly behind their module"
                             : "a module is a declared name, a letter or a sign of the turtle");
      return std::nullopt;
    }
    at += name->size();
    std::vector<LpyValue> parameters;
    if (at < all.text.size() && all.text[at] == '(') {
      const std::size_t end = behindParenthesis(all.text, at);
      if (end == std::string_view::npos) {
        report_.error(all.offset + at, 1, "the parenthesis '(' of " + *name + " is never closed",
                      "the parameters of a module stand between '(' and ')'");
        return std::nullopt;
      }
      const TextPiece list{all.text.substr(at + 1, end - at - 2), all.offset + at + 1};
      for (const TextPiece& argument : lpyArguments(list)) {
        const auto value = translateLpyExpression(argument, scope, draws_, report_);
        if (!value) {
          return std::nullopt;
        }
        parameters.push_back(*value);
      }
      at = end;
    }
    (void)appendModule(result, *name, parameters, target, offset);
  }
  return result;
}

// ---- heads of rules

std::optional<std::string> LpyRules::readFormal(const TextPiece& parameter, LpyScope& scope, Head& head) {
  const std::size_t condition = parameter.text.find(" if ");
  const TextPiece front = parameter.to(condition).trimmed();
  std::string name(front.text);
  if (!isIdentifier(name)) {
    const auto value = translateLpyExpression(front, scope_, draws_, report_);
    if (!value || !value->number) {
      refuse(parameter, "the parameter '" + std::string(parameter.text.substr(0, 40)) + "' of a predecessor");
      return std::nullopt;
    }
    // a constant is a condition
    name = "value" + std::to_string(++formalCount_);
    head.conditions.push_back("(" + name + "==" + value->text + ")");
    return name;
  }
  scope.values[name] = {lpyName(name), std::nullopt};
  if (condition != std::string_view::npos) {
    const auto value = translateLpyExpression(parameter.from(condition + 4).trimmed(), scope, draws_, report_);
    if (!value) {
      return std::nullopt;
    }
    head.conditions.push_back(value->text);
  }
  return lpyName(name);
}

bool LpyRules::readFormals(const TextPiece& text, LpyScope& scope, Head& head) {
  for (std::size_t at = 0; at < text.text.size();) {
    if (text.text[at] == ' ' || text.text[at] == '\t') {
      ++at;
      continue;
    }
    const std::size_t offset = text.offset + at;
    const auto name = nameAt(text.text.substr(at));
    if (!name) {
      report_.error(offset, 1,
                    "expected a module while reading a rule, found '" + std::string(text.text.substr(at, 20)) + "'",
                    "write 'A(x) --> B(x)' or 'A(x) :' with an indented block behind it");
      return false;
    }
    at += name->size();
    std::vector<std::string> formals;
    if (at < text.text.size() && text.text[at] == '(') {
      const std::size_t end = behindParenthesis(text.text, at);
      if (end == std::string_view::npos) {
        report_.error(text.offset + at, 1, "the parenthesis '(' of " + *name + " is never closed",
                      "the parameters of a module stand between '(' and ')'");
        return false;
      }
      for (const TextPiece& parameter : lpyArguments({text.text.substr(at + 1, end - at - 2), text.offset + at + 1})) {
        const auto formal = readFormal(parameter, scope, head);
        if (!formal) {
          return false;
        }
        formals.push_back(*formal);
      }
      at = end;
    }
    if (isIdentifier(*name) && name->size() > 1) {
      used_.insert(*name);
    }
    head.text.make(called(*name, formals), offset);
  }
  return true;
}

std::optional<LpyRules::Head> LpyRules::readHead(const TextPiece& text, LpyScope& scope) {
  Head head;
  int depth = 0;
  std::size_t begin = 0;
  for (std::size_t at = 0; at <= text.text.size(); ++at) {
    const bool isEnd = at == text.text.size();
    const char c = isEnd ? '\0' : text.text[at];
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (!isEnd && (depth != 0 || (c != '<' && c != '>' && c != ':'))) {
      continue;
    }
    if (!readFormals({text.text.substr(begin, at - begin), text.offset + begin}, scope, head)) {
      return std::nullopt;
    }
    if (c == ':') {
      const auto condition = translateLpyExpression(text.from(at + 1).trimmed(), scope, draws_, report_);
      if (!condition) {
        return std::nullopt;
      }
      head.conditions.push_back(condition->text);
      break;
    }
    if (!isEnd) {
      const bool isDouble = text.text.substr(at).starts_with(std::string(2, c));
      head.text.make(" " + std::string(isDouble ? 2 : 1, c) + " ", text.offset + at);
      at += isDouble ? 1 : 0;
      begin = at + 1;
    }
  }
  return head;
}

void LpyRules::addRule(const TextPiece& headText, const std::optional<TextPiece>& successor,
                       const std::vector<PythonStatement>& block, LpyTarget target,
                       std::vector<MappedText>& productions) {
  draws_.statements.clear();
  draws_.areNamed = !successor;
  hasFailed_ = false;
  repetitions_ = 0;
  Path start{scope_, {}, {}, {}, {}, false, false};
  const auto head = readHead(headText, start.scope);
  if (!head) {
    return;
  }
  std::vector<Path> paths{std::move(start)};
  if (successor) {
    const auto text = modules(*successor, paths.front().scope, target);
    if (!text) {
      return;
    }
    paths.front().successor = *text;
    paths.front().hasSuccessor = true;
  } else {
    runStatements(block, target, paths);
  }
  if (hasFailed_) {
    return;
  }
  std::string before = draws_.statements.empty() ? std::string{} : "{" + joined(draws_.statements, " ") + "} ";
  for (const Path& path : paths) {
    if (!path.hasSuccessor) {
      continue;
    }
    std::vector<std::string> conditions = head->conditions;
    conditions.insert(conditions.end(), path.conditions.begin(), path.conditions.end());
    MappedText production = head->text;
    const std::string behind = path.assignments.empty() ? std::string{} : " {" + joined(path.assignments, " ") + "}";
    if (!conditions.empty() || !before.empty() || !behind.empty()) {
      production.make(" : " + before + (conditions.empty() ? "*" : joined(conditions, " && ")) + behind,
                      headText.offset);
      before.clear();
    }
    production.make(" --> ", headText.offset);
    production.add(path.successor.empty() ? MappedText("*", headText.offset) : path.successor);
    productions.push_back(std::move(production));
  }
}

std::optional<MappedText> LpyRules::axiom(const std::vector<PythonStatement>& block) {
  hasFailed_ = false;
  repetitions_ = 0;
  std::vector<Path> paths{Path{scope_, {}, {}, {}, {}, false, false}};
  runStatements(block, LpyTarget::String, paths);
  if (!hasFailed_ && (paths.size() > 1 || !paths.front().assignments.empty())) {
    refuse(block.front().code, "an axiom that depends on a random number or changes a variable");
  }
  return hasFailed_ ? std::nullopt : std::optional(paths.front().successor);
}

// ---- blocks of rules

bool LpyRules::countRepetition(const TextPiece& loop, std::size_t paths) {
  repetitions_ += paths;
  if (!hasFailed_ && repetitions_ > kMostLoopRuns) {
    hasFailed_ = true;
    report_.error(loop.offset, loop.text.size(), "the loops of a block repeat more than 100000 times",
                  "loops are written out: write a rule that counts instead");
  }
  return !hasFailed_;
}

void LpyRules::refuse(const TextPiece& code, const std::string& what) {
  hasFailed_ = true;
  report_.error(code.offset, code.text.size(), what + " needs Python", std::string(kNeedsPython));
}

void LpyRules::runStatements(const std::vector<PythonStatement>& statements, LpyTarget target,
                             std::vector<Path>& paths) {
  for (std::size_t i = 0; i < statements.size() && !hasFailed_; ++i) {
    const PythonStatement& statement = statements[i];
    const std::string word = firstWord(statement.code).first;
    if (word == "if") {
      runIf(statements, i, target, paths);
    } else if (word == "for") {
      // the names of the rule are known, so that a bound that is not constant is named as such
      const auto loop = loopOf(statement.code, paths.empty() ? scope_ : paths.front().scope, draws_, report_);
      hasFailed_ = hasFailed_ || !loop;
      for (const double value : loop ? loop->values : std::vector<double>{}) {
        if (!countRepetition(statement.code, paths.size())) {
          break;
        }
        for (Path& path : paths) {
          path.scope.values[loop->variable] = lpyConstant(value);
        }
        runStatements(statement.body, target, paths);
      }
    } else if (statement.isCompound) {
      refuse(statement.code, "'" + word + "'");
    } else {
      for (Path& path : paths) {
        if (!path.isDone && !hasFailed_) {
          runOne(statement, target, path);
        }
      }
    }
    if (paths.size() > kMostPaths) {
      refuse(statement.code, "a block with more than 500 ways through it");
    }
  }
}

void LpyRules::runIf(const std::vector<PythonStatement>& statements, std::size_t& index, LpyTarget target,
                     std::vector<Path>& paths) {
  std::vector<Path> results;
  std::vector<Path> open;
  for (Path& path : paths) {
    (path.isDone ? results : open).push_back(std::move(path));
  }
  std::size_t last = index;
  for (std::size_t i = index; i < statements.size() && !hasFailed_; ++i) {
    const auto [word, condition] = firstWord(statements[i].code);
    if (i > index && word != "elif" && word != "else") {
      break;
    }
    last = i;
    std::vector<Path> taken;
    std::vector<Path> others;
    for (Path& path : open) {
      const auto value = word == "else" ? std::optional(lpyConstant(1.0))
                                        : translateLpyExpression(condition, path.scope, draws_, report_);
      hasFailed_ = hasFailed_ || !value;
      if (hasFailed_) {
        return;
      }
      if (value->number) {
        (*value->number != 0.0 ? taken : others).push_back(std::move(path));
        continue;
      }
      others.push_back(path);
      others.back().conditions.push_back(negated(value->text));
      path.conditions.push_back(value->text);
      taken.push_back(std::move(path));
    }
    runStatements(statements[i].body, target, taken);
    std::move(taken.begin(), taken.end(), std::back_inserter(results));
    open = std::move(others);
  }
  std::move(open.begin(), open.end(), std::back_inserter(results));
  paths = std::move(results);
  index = last;
}

void LpyRules::runOne(const PythonStatement& statement, LpyTarget target, Path& path) {
  const auto [word, rest] = firstWord(statement.code);
  if (word == "produce" || word == "nproduce") {
    const auto text = modules(rest, path.scope, target);
    if (!text) {
      hasFailed_ = true;
      return;
    }
    path.successor.add(*text);
    path.hasSuccessor = true;
    path.isDone = word == "produce";
  } else if (word == "global") {
    for (const TextPiece& name : lpyArguments(rest)) {
      path.globals.insert(std::string(name.text));
    }
  } else if (word == "return" && rest.empty()) {
    path.isDone = true;
  } else if (const auto assignment = assignmentOf(statement.code)) {
    assign(*assignment, path);
  } else if (word != "pass" && word != "print") {
    refuse(statement.code, "'" + std::string(statement.code.text.substr(0, 40)) + "'");
  }
}

void LpyRules::assign(const PythonAssignment& assignment, Path& path) {
  auto value = translateLpyExpression(assignment.value, path.scope, draws_, report_);
  if (!value) {
    hasFailed_ = true;
    return;
  }
  const bool isGlobal = path.globals.contains(assignment.name);
  if (assignment.operation != '=') {
    const auto old = path.scope.values.find(assignment.name);
    if (old == path.scope.values.end() && !isGlobal) {
      refuse(assignment.value, "the assignment to the unknown name '" + assignment.name + "'");
      return;
    }
    const LpyValue before = isGlobal ? LpyValue{lpyName(assignment.name), std::nullopt} : old->second;
    const bool isConstant = before.number && value->number;
    const double a = before.number.value_or(0.0);
    const double b = value->number.value_or(1.0);
    const char operation = assignment.operation;
    value = isConstant ? lpyConstant(operation == '+'   ? a + b
                                     : operation == '-' ? a - b
                                     : operation == '*' ? a * b
                                                        : a / b)
                       : LpyValue{"(" + before.text + operation + value->text + ")", std::nullopt};
  }
  if (isGlobal) {
    path.assignments.push_back(lpyName(assignment.name) + " = " + value->text + ";");
    path.scope.values.erase(assignment.name);
    path.scope.variables.insert(assignment.name);
    return;
  }
  path.scope.values[assignment.name] = std::move(*value);
}

// ---- Start and its relatives

std::string LpyRules::blockText(const std::vector<PythonStatement>& statements, LpyScope& scope,
                                std::set<std::string>& globals) {
  std::string text;
  draws_.areNamed = false;
  const auto add = [&](const std::string& part) { text += (text.empty() || part.empty() ? "" : " ") + part; };
  for (const PythonStatement& statement : statements) {
    const auto [word, rest] = firstWord(statement.code);
    if (word == "global") {
      for (const TextPiece& name : lpyArguments(rest)) {
        globals.insert(std::string(name.text));
      }
    } else if (word == "if" || word == "elif" || word == "else") {
      const auto condition =
          word == "else" ? std::optional(lpyConstant(1.0)) : translateLpyExpression(rest, scope, draws_, report_);
      if (!condition) {
        return text;
      }
      const std::string inner = blockText(statement.body, scope, globals);
      // cpfg has no empty block
      const std::string body = "{ " + (inner.empty() ? "0;" : inner) + " }";
      // an `elif` is a block around another `if`, which ends with the text
      add(word == "if" ? "if (" + condition->text + ") " + body
                       : "else " + (word == "else" ? body : "if (" + condition->text + ") " + body));
    } else if (word == "for") {
      const auto loop = loopOf(statement.code, scope, draws_, report_);
      for (const double value : loop ? loop->values : std::vector<double>{}) {
        if (!countRepetition(statement.code, 1)) {
          break;
        }
        scope.values[loop->variable] = lpyConstant(value);
        add(blockText(statement.body, scope, globals));
      }
    } else if (const auto assignment = assignmentOf(statement.code); assignment && !statement.isCompound) {
      const auto value = translateLpyExpression(assignment->value, scope, draws_, report_);
      if (!value) {
        return text;
      }
      const bool isGlobal = globals.contains(assignment->name);
      const std::string name = isGlobal ? lpyName(assignment->name) : "local" + assignment->name;
      const std::string right =
          assignment->operation == '=' ? value->text : name + " " + assignment->operation + " " + value->text;
      add(name + " = " + right + ";");
      if (isGlobal) {
        scope.variables.insert(assignment->name);
        scope.values.erase(assignment->name);
      } else {
        scope.values[assignment->name] = {name, std::nullopt};
      }
    } else if (word != "pass" && word != "print" && !(word == "forward" && rest.text.starts_with('('))) {
      refuse(statement.code, "'" + std::string(statement.code.text.substr(0, 40)) + "'");
    }
  }
  return text;
}

// ---- at the end

void LpyRules::addDrawing(std::vector<MappedText>& drawing) const {
  for (const auto& [name, counts] : arities_) {
    for (const std::size_t count : counts) {
      std::vector<std::string> formals;
      for (std::size_t i = 0; i < count; ++i) {
        formals.push_back("x" + std::to_string(i + 1));
      }
      if (const auto modules = drawingOf(name, formals)) {
        drawing.emplace_back(called(name, formals) + " --> " + (modules->empty() ? "*" : *modules), 0);
      }
    }
  }
}

std::string LpyRules::declarations() const {
  std::string names;
  for (const std::string& name : used_) {
    names += (names.empty() ? "" : ", ") + name + "(...)";
  }
  return names.empty() ? names : "Module: " + names;
}

std::string LpyRules::drawVariables() const {
  std::string text;
  for (std::size_t i = 1; i <= draws_.count; ++i) {
    text += (text.empty() ? "random" : " random") + std::to_string(i) + " = 0;";
  }
  return text;
}

}  // namespace espalier::language

#include "engine/language/dialects/textbook/textbook_statements.h"

#include <array>

#include "engine/core/diagnostic.h"
#include "engine/core/number_text.h"
#include "engine/core/work_meter.h"
#include "engine/language/dialects/textbook/textbook_modules.h"
#include "engine/language/dialects/textbook/textbook_signs.h"
#include "engine/language/dialects/textbook/textbook_words.h"

namespace espalier::language {
namespace {

constexpr std::array<std::string_view, 12> kArrows{"→", "⟶", "⇒",   "⟹",  "↦",   "➔",
                                                   "➝", "➞", "-->", "->", "::=", kRuleMark};

struct SettingName {
  std::string_view name;  // small letters
  Setting setting;
};

constexpr std::array kSettings = {
    SettingName{"ω", Setting::Axiom},
    SettingName{"w", Setting::Axiom},
    SettingName{"omega", Setting::Axiom},
    SettingName{"axiom", Setting::Axiom},
    SettingName{"axioma", Setting::Axiom},
    SettingName{"axiomat", Setting::Axiom},
    SettingName{"axiome", Setting::Axiom},
    SettingName{"start", Setting::Axiom},
    SettingName{"start string", Setting::Axiom},
    SettingName{"initiator", Setting::Axiom},
    SettingName{"initial string", Setting::Axiom},
    SettingName{"initial state", Setting::Axiom},
    SettingName{"start symbol", Setting::Axiom},
    SettingName{"l", Setting::Axiom},
    SettingName{"α", Setting::Axiom},
    SettingName{"wm", Setting::Axiom},
    SettingName{"wd", Setting::Axiom},
    SettingName{"δ", Setting::Angle},
    SettingName{"θ", Setting::Angle},
    SettingName{"delta", Setting::Angle},
    SettingName{"theta", Setting::Angle},
    SettingName{"angle", Setting::Angle},
    SettingName{"angle increment", Setting::Angle},
    SettingName{"turn angle", Setting::Angle},
    SettingName{"turning angle", Setting::Angle},
    SettingName{"angle of rotation", Setting::Angle},
    SettingName{"rotation", Setting::Angle},
    SettingName{"b", Setting::Angle},
    SettingName{"n", Setting::Steps},
    SettingName{"steps", Setting::Steps},
    SettingName{"iteracja", Setting::Steps},
    SettingName{"iterations", Setting::Steps},
    SettingName{"iteration", Setting::Steps},
    SettingName{"number of iterations", Setting::Steps},
    SettingName{"iter", Setting::Steps},
    SettingName{"generations", Setting::Steps},
    SettingName{"generation", Setting::Steps},
    SettingName{"recursions", Setting::Steps},
    SettingName{"recursion", Setting::Steps},
    SettingName{"depth", Setting::Steps},
    SettingName{"order", Setting::Steps},
    SettingName{"level", Setting::Steps},
    SettingName{"levels", Setting::Steps},
    SettingName{"maxgen", Setting::Steps},
    SettingName{"derivation length", Setting::Steps},
    SettingName{"α0", Setting::Heading},
    SettingName{"alpha0", Setting::Heading},
    SettingName{"heading", Setting::Heading},
    SettingName{"initial heading", Setting::Heading},
    SettingName{"start angle", Setting::Heading},
    SettingName{"d", Setting::Step},
    SettingName{"step", Setting::Step},
    SettingName{"step length", Setting::Step},
    SettingName{"turns", Setting::Turns},
    SettingName{"p", Setting::Productions},
    SettingName{"pm", Setting::Productions},
    SettingName{"pd", Setting::Productions},
    SettingName{"rule", Setting::Productions},
    SettingName{"rules", Setting::Productions},
    SettingName{"production", Setting::Productions},
    SettingName{"productions", Setting::Productions},
    SettingName{"production rules", Setting::Productions},
    SettingName{"production rule", Setting::Productions},
    SettingName{"rewriting rules", Setting::Productions},
    SettingName{"replacement rules", Setting::Productions},
    SettingName{"ignore", Setting::Ignore},
    SettingName{"consider", Setting::Consider},
    SettingName{"v", Setting::Sets},
    SettingName{"g", Setting::Sets},
    SettingName{"a", Setting::Sets},
    SettingName{"s", Setting::Sets},
    SettingName{"σ", Setting::Sets},
    SettingName{"gm", Setting::Sets},
    SettingName{"gd", Setting::Sets},
    SettingName{"alphabet", Setting::Sets},
    SettingName{"variable", Setting::Sets},
    SettingName{"variables", Setting::Sets},
    SettingName{"constant", Setting::Sets},
    SettingName{"constants", Setting::Sets},
    SettingName{"name", Setting::Sets},
    SettingName{"title", Setting::Sets},
    SettingName{"author", Setting::Sets},
    SettingName{"source", Setting::Sets},
    SettingName{"description", Setting::Sets},
    SettingName{"comment", Setting::Sets},
};

constexpr std::array<std::pair<std::string_view, std::string_view>, 26> kGreek{
    {{"α", "alpha"}, {"β", "beta"}, {"γ", "gamma"}, {"δ", "delta"},  {"ε", "epsilon"}, {"ζ", "zeta"},    {"η", "eta"},
     {"θ", "theta"}, {"ι", "iota"}, {"κ", "kappa"}, {"λ", "lambda"}, {"μ", "mu"},      {"µ", "mu"},      {"ν", "nu"},
     {"ξ", "xi"},    {"π", "pi"},   {"ρ", "rho"},   {"σ", "sigma"},  {"τ", "tau"},     {"υ", "upsilon"}, {"φ", "phi"},
     {"ϕ", "phi"},   {"χ", "chi"},  {"ψ", "psi"},   {"ω", "omega"},  {"Δ", "Delta"}}};

// signs of print in constant expressions
constexpr std::array<std::pair<std::string_view, std::string_view>, 10> kConstantSigns{{{"°", ""},
                                                                                        {"º", ""},
                                                                                        {"◦", ""},
                                                                                        {"×", "*"},
                                                                                        {"·", "*"},
                                                                                        {"⋅", "*"},
                                                                                        {"÷", "/"},
                                                                                        {"∧", "^"},
                                                                                        {"²", "^2"},
                                                                                        {"³", "^3"}}};

bool isLetterOrDigit(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0;
}

// a line without its remark: `//`, `#` and `;` at its beginning, and ` // ` or ` # ` behind blanks. In an open bracket
// of the lines before, two slashes are judged as in a production
template <typename IsRemark>
TextPiece withoutRemark(const TextPiece& line, bool isInBracket, IsRemark isRemarkBehind) {
  const std::string_view text = line.text;
  const TextPiece code = line.trimmed();
  const bool isDirective = code.text.starts_with('#') && code.text.size() > 1 && isLetterOrDigit(code.text[1]);
  const bool isSlashed = code.text.starts_with("//") && (!isInBracket || isRemarkBehind(code.from(2).text));
  if (isSlashed || code.text.starts_with(';') || (code.text.starts_with('#') && !isDirective)) {
    return {};
  }
  const bool hasArrow = arrowOf(text).has_value();
  bool areRolls = false;
  for (std::size_t at = 1; at < text.size(); ++at) {
    core::pollWork();
    const bool isSlashes = text.substr(at).starts_with("//");
    const bool isSign = (isSlashes && !areRolls) || text[at] == '#';
    const std::size_t behind = at + (isSlashes ? 2 : 1);
    const bool isBeforeBlank = behind >= text.size() || text[behind] == ' ' || text[behind] == '\t';
    // in a string of modules two slashes are two rolls, and '#' is a symbol
    const bool hasModules = hasArrow || (isSlashes && isInBracket);
    if (!isSign || (text[at - 1] != ' ' && text[at - 1] != '\t') || (!isBeforeBlank && hasModules) || isDirective) {
      continue;
    }
    if (!isSlashes || !hasModules || isRemarkBehind(text.substr(std::min(behind, text.size())))) {
      return line.to(at).trimmed();
    }
    areRolls = true;
  }
  return code;
}

std::ptrdiff_t openBrackets(std::string_view text) {
  return std::count(text.begin(), text.end(), '[') - std::count(text.begin(), text.end(), ']');
}

int depthChange(char c) {
  // square brackets stand alone in a set of productions: `[ → [`
  return c == '(' || c == '{' ? 1 : c == ')' || c == '}' ? -1 : 0;
}

// the parts of a text between commas and semicolons outside of brackets, joined where `divides(part, rest)` says no
template <typename Divides>
std::vector<TextPiece> partsOf(const TextPiece& text, Divides divides) {
  std::vector<TextPiece> parts;
  int depth = 0;
  std::size_t begin = 0;
  for (std::size_t at = 0; at <= text.text.size(); ++at) {
    core::pollWork();
    const bool isEnd = at == text.text.size();
    depth += isEnd ? 0 : depthChange(text.text[at]);
    if (!isEnd && (depth != 0 || (text.text[at] != ',' && text.text[at] != ';'))) {
      continue;
    }
    const TextPiece part = TextPiece{text.text.substr(begin, at - begin), text.offset + begin}.trimmed();
    if (isEnd || divides(part, text.from(at + 1))) {
      if (!part.empty()) {
        parts.push_back(part);
      }
      begin = at + 1;
    }
  }
  return parts;
}

// `a)` or `(a)` before the settings of a caption
TextPiece withoutCaptionLabel(const TextPiece& line) {
  const std::size_t open = line.text.starts_with('(') ? 1 : 0;
  const bool isLabel = line.text.size() > open + 2 && std::islower(static_cast<unsigned char>(line.text[open])) != 0 &&
                       line.text[open + 1] == ')' && line.text[open + 2] == ' ';
  return isLabel ? line.from(open + 2).trimmed() : line;
}

// the text up to the next comma or semicolon outside of brackets
TextPiece firstPartOf(const TextPiece& text) {
  int depth = 0;
  std::size_t end = 0;
  for (; end < text.text.size() && (depth > 0 || (text.text[end] != ',' && text.text[end] != ';')); ++end) {
    depth += depthChange(text.text[end]);
  }
  return text.to(end).trimmed();
}

// `angel: 60`: a word and a number, though no setting has that name
bool isUnknownSetting(const TextPiece& part) {
  const std::size_t mark = part.text.find_first_of(":=");
  if (mark == std::string_view::npos || !textbookNumber(part.from(mark + 1).trimmed().text)) {
    return false;
  }
  const std::string_view word = part.to(mark).trimmed().text;
  return word.size() > 2 && std::all_of(word.begin(), word.end(), [](char c) { return c >= 'a' && c <= 'z'; });
}

// a line with an arrow: `axiom: F; F -> F+F; angle: 60` has three statements, `A(x); x > 2 -> F` one
void addProductions(const TextPiece& line, std::vector<TextPiece>& statements) {
  const auto divides = [&line](const TextPiece& part, const TextPiece& rest) {
    // an axiom may have commas, and a condition semicolons
    const bool isSemicolon = line.text[rest.offset - line.offset - 1] == ';';
    const TextPiece next = firstPartOf(rest);
    const auto setting = settingOf(next);
    const bool hasArrow = arrowOf(isSemicolon && !setting ? rest.text : next.text).has_value();
    const auto before = arrowOf(part.text) ? std::nullopt : settingOf(part);
    const bool isPlain = before && before->setting != Setting::Productions;
    const bool isBegun = isPlain || arrowOf(part.text);
    const bool isHeading = setting && setting->setting == Setting::Productions && setting->name.size() > 2;
    return isBegun && (hasArrow ? isPlain || isHeading : setting || (isSemicolon && isUnknownSetting(next)));
  };
  for (const TextPiece& part : partsOf(line, divides)) {
    statements.push_back(part);
  }
}

void addSettings(const TextPiece& line, std::vector<TextPiece>& statements) {
  const auto beginsSetting = [](const TextPiece&, const TextPiece& rest) {
    const std::size_t equals = rest.text.find_first_of("=:,;");
    return equals != std::string_view::npos && (rest.text[equals] == '=' || rest.text[equals] == ':') &&
           (settingOf(rest.trimmed()) || rest.text[equals] == '=');
  };
  const TextPiece code = withoutCaptionLabel(line);
  for (const TextPiece& part : partsOf(code, beginsSetting)) {
    statements.push_back(part);
  }
}

TextPiece withoutEnd(TextPiece code) {
  const bool isListed = code.text.ends_with("),") && code.text.starts_with('(');
  if (isListed || (code.text.ends_with(';') && code.text.size() > 1)) {
    code = code.to(code.text.size() - 1).trimmed();
  }
  return code;
}

TextPiece withoutQuotes(const TextPiece& value) {
  const bool isQuoted = value.text.size() > 1 && (value.text.front() == '"' || value.text.front() == '\'') &&
                        value.text.back() == value.text.front();
  return isQuoted ? value.from(1).to(value.text.size() - 2).trimmed() : value;
}

}  // namespace

std::optional<std::pair<std::size_t, std::size_t>> arrowOf(std::string_view text) {
  core::pollWork();
  std::optional<std::pair<std::size_t, std::size_t>> first;
  for (const std::string_view arrow : kArrows) {
    const std::size_t at = text.find(arrow);
    if (at != std::string_view::npos && (!first || at < first->first)) {
      first = {at, arrow.size()};
    }
  }
  return first;
}

std::vector<TextPiece> textbookStatements(std::string_view text, std::vector<TextPiece>* remarks) {
  std::vector<TextPiece> statements;
  std::optional<std::set<std::string_view>> predecessors;
  const auto isRemarkBehind = [&](std::string_view slashes) {
    if (!predecessors) {
      predecessors = wordsOfPredecessors(text);
    }
    return isRemark(slashes, *predecessors);
  };
  // of the last statement, which grows with each line that continues it
  bool isProduction = false;
  std::ptrdiff_t open = 0;
  for (const TextPiece& line : linesOf(text)) {
    const bool isInBracket = isProduction && open > 0;
    const TextPiece plain = withoutRemark(line, isInBracket, isRemarkBehind);
    if (remarks != nullptr) {
      remarks->push_back(plain.empty() ? line : line.from(plain.offset + plain.text.size() - line.offset));
    }
    const TextPiece code = withoutEnd(plain);
    if (code.empty()) {
      continue;
    }
    const auto arrow = arrowOf(code.text);
    const bool joinsArrow = arrow && arrow->first == 0 && !statements.empty() && !isProduction;
    // a rest of a successor: indented, in an open bracket, or with a sign at its beginning
    const bool isRest =
        isProduction && !arrow && !code.text.starts_with('#') &&
        (code.offset > line.offset ||
         std::string_view("[]{}+-&^/\\|").find(code.text.front()) != std::string_view::npos || isInBracket) &&
        code.text.find_first_of(":=") == std::string_view::npos && !settingOf(code);
    if (joinsArrow || isRest) {
      TextPiece& last = statements.back();
      last.text = text.substr(last.offset, code.offset + code.text.size() - last.offset);
      isProduction = true;
      open += openBrackets(code.text);
      continue;
    }
    if (arrow) {
      addProductions(code, statements);
    } else {
      addSettings(code, statements);
    }
    isProduction = !statements.empty() && arrowOf(statements.back().text);
    open = statements.empty() ? 0 : openBrackets(statements.back().text);
  }
  return statements;
}

std::optional<NamedValue> settingOf(const TextPiece& statement) {
  core::pollWork();
  const std::size_t at = statement.text.find_first_of(":=");
  const auto find = [](std::string name) {
    if (name.ends_with(')') && name.find('(') != std::string::npos) {
      name = std::string(TextPiece{std::string_view(name).substr(0, name.find('(')), 0}.trimmed().text);
    }
    // a subscript 0 belongs to the name
    for (const std::string_view zero : {"_0", "_{0}", "₀"}) {
      if (name.ends_with(zero)) {
        name.replace(name.size() - zero.size(), zero.size(), "0");
      }
    }
    return std::find_if(kSettings.begin(), kSettings.end(), [&](const auto& entry) { return entry.name == name; });
  };
  if (at != std::string_view::npos) {
    const auto found = find(lowered(statement.to(at).trimmed().text));
    if (found != kSettings.end()) {
      const TextPiece value = withoutQuotes(statement.from(at + 1).trimmed());
      // α is an angle when it is a number
      const bool isAngle = found->name == "α" && textbookNumber(value.text).has_value();
      return NamedValue{isAngle ? Setting::Angle : found->setting, std::string(found->name), value};
    }
  }
  // `axiom F`: a long name and a blank
  const std::size_t blank = statement.text.find_first_of(" \t");
  constexpr std::size_t kLongName = 4;
  if (blank == std::string_view::npos || blank < kLongName) {
    return std::nullopt;
  }
  const auto found = find(lowered(statement.to(blank).text));
  if (found == kSettings.end()) {
    return std::nullopt;
  }
  return NamedValue{found->setting, std::string(found->name), withoutQuotes(statement.from(blank).trimmed())};
}

std::string_view nearestSetting(std::string_view name) {
  std::vector<std::string_view> names;
  for (const SettingName& setting : kSettings) {
    if (setting.name.size() > 3) {
      names.push_back(setting.name);
    }
  }
  return core::nearestName(name, names);
}

std::vector<TextPiece> axiomsOf(TextPiece value) {
  if (value.text.starts_with('{') && value.text.ends_with('}')) {
    value = value.from(1).to(value.text.size() - 2);
  }
  std::vector<TextPiece> axioms;
  int depth = 0;
  std::size_t begin = 0;
  for (std::size_t at = 0; at <= value.text.size(); ++at) {
    const char c = at < value.text.size() ? value.text[at] : ',';
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c == ',' && (depth == 0 || at == value.text.size())) {
      axioms.push_back(TextPiece{value.text.substr(begin, at - begin), value.offset + begin}.trimmed());
      begin = at + 1;
    }
  }
  const bool isSet = std::none_of(axioms.begin(), axioms.end(), [](const TextPiece& axiom) { return axiom.empty(); });
  return isSet ? axioms : std::vector<TextPiece>{value};
}

std::optional<NamedValue> axiomOf(std::string_view text) {
  for (const TextPiece& statement : textbookStatements(text)) {
    const auto setting = arrowOf(statement.text) ? std::nullopt : settingOf(statement);
    if (setting && setting->setting == Setting::Axiom) {
      return setting;
    }
  }
  return std::nullopt;
}

TextPiece withoutLabel(const TextPiece& statement) {
  const std::size_t end = statement.text.find_first_of(":)=");
  const auto arrow = arrowOf(statement.text);
  if (end == std::string_view::npos || (arrow ? arrow->first < end : statement.text[end] == '=')) {
    return statement;
  }
  const std::string label = lowered(statement.to(end).trimmed().text);
  std::size_t at = 0;
  for (const std::string_view word : {"production", "rule", "p", "r"}) {
    if (at == 0 && label.starts_with(word)) {
      at = word.size();
    }
  }
  const bool isLetter = at == 1;
  const std::size_t wordEnd = at;
  at = std::min(label.find_first_not_of(" #", at), label.size());
  while (at < label.size() && std::isdigit(static_cast<unsigned char>(label[at])) != 0) {
    ++at;
  }
  (void)readSubscript(label, at);
  // `r:` alone is a symbol with a condition, and `4)` a number
  const bool hasNumber = at > wordEnd;
  const bool isLabel = statement.text[end] == ')' ? hasNumber && wordEnd == 0
                                                  : wordEnd > 0 && (hasNumber || !isLetter || label.front() == 'p');
  return at == label.size() && isLabel ? statement.from(end + 1).trimmed() : statement;
}

TextPiece withoutAnyContext(TextPiece predecessor) {
  if (predecessor.text.starts_with('*') && predecessor.from(1).trimmed().text.starts_with('<')) {
    predecessor = predecessor.from(1).trimmed().from(1).trimmed();
  }
  if (predecessor.text.ends_with('*')) {
    const TextPiece front = predecessor.to(predecessor.text.size() - 1).trimmed();
    predecessor = front.text.ends_with('>') ? front.to(front.text.size() - 1).trimmed() : predecessor;
  }
  return predecessor;
}

std::vector<TextPiece> productionsOf(TextPiece value) {
  if (value.text.starts_with('{') && value.text.ends_with('}')) {
    value = value.from(1).to(value.text.size() - 2);
  }
  // a comma ends a production when the text behind it, up to the next comma, has an arrow; the semicolon before a
  // condition stands before the arrow
  const auto beginsProduction = [](const TextPiece& part, const TextPiece& rest) {
    return arrowOf(part.text) && (rest.trimmed().empty() || arrowOf(firstPartOf(rest).text));
  };
  std::vector<TextPiece> parts = partsOf(value, beginsProduction);
  for (TextPiece& part : parts) {
    const auto arrow = arrowOf(part.text);
    // `(X → F)`
    if (arrow && part.text.starts_with('(') && part.text.ends_with(')') &&
        part.text.substr(0, arrow->first).find(')') == std::string_view::npos) {
      part = part.from(1).to(part.text.size() - 2).trimmed();
    }
  }
  return parts;
}

std::string readTextbookName(std::string_view text, std::size_t& at) {
  std::string name;
  std::size_t position = at;
  const auto addLetter = [&]() {
    if (position < text.size() && std::isalpha(static_cast<unsigned char>(text[position])) != 0) {
      name += text[position++];
      return true;
    }
    for (const auto& [letter, word] : kGreek) {
      if (text.substr(position).starts_with(letter)) {
        name += word;
        position += letter.size();
        return true;
      }
    }
    return false;
  };
  if (!addLetter()) {
    return {};
  }
  for (bool isFound = true; isFound;) {
    isFound = addLetter();
    while (position < text.size() && std::isdigit(static_cast<unsigned char>(text[position])) != 0) {
      name += text[position++];
      isFound = true;
    }
    const std::size_t before = position;
    const Subscript subscript = readSubscript(text, position);
    if (position > before) {
      name += subscript.kind == Subscript::Kind::Number ? std::to_string(subscript.shift) : subscript.name;
      isFound = true;
    } else if (position < text.size() && text[position] == '_') {
      ++position;
      isFound = true;
    }
  }
  std::erase_if(name, [](char c) { return !isLetterOrDigit(c); });
  at = position;
  return name;
}

namespace {

// the names in the expressions of a production or axiom but its formal parameters: in parentheses, in the condition,
// behind the last colon
void addUsedNames(const TextPiece& statement, std::set<std::string>& names) {
  const TextPiece production = withoutLabel(statement);
  const std::string_view text = production.text;
  const auto arrow = arrowOf(text);
  const std::size_t arrowAt = arrow ? arrow->first : 0;
  const std::size_t condition = std::min(arrowAt, conditionMark(text.substr(0, arrowAt)));
  const std::size_t probability = arrow ? text.rfind(':') : std::string_view::npos;
  std::set<std::string> formals;
  int depth = 0;
  for (std::size_t at = 0; at < text.size();) {
    depth += text[at] == '(' ? 1 : text[at] == ')' ? -1 : 0;
    const bool isInHead = arrow && at < condition;
    const bool isCondition = arrow && at >= condition && at < arrowAt;
    const bool isProbability = probability != std::string_view::npos && probability > arrowAt && at > probability;
    std::string name = depth > 0 || isCondition || isProbability ? readTextbookName(text, at) : std::string{};
    if (name.empty()) {
      ++at;
    } else if (isInHead) {
      formals.insert(std::move(name));
    } else if (!formals.contains(name)) {
      names.insert(std::move(name));
    }
  }
}

// a constant expression as cpfg text; nothing when a part is neither a number, an operator nor a known constant
std::optional<std::string> constantText(std::string_view text, const std::map<std::string, std::string>& constants) {
  std::string result;
  bool hasValue = false;
  for (std::size_t at = 0; at < text.size();) {
    const std::string name = readTextbookName(text, at);
    if (!name.empty()) {
      const auto known = constants.find(name);
      if (known == constants.end() && name != "pi") {
        return std::nullopt;
      }
      result += known == constants.end() ? name : "(" + known->second + ")";
      hasValue = true;
      continue;
    }
    const char c = text[at];
    const auto* const sign = std::find_if(kConstantSigns.begin(), kConstantSigns.end(),
                                          [&](const auto& pair) { return text.substr(at).starts_with(pair.first); });
    if (sign != kConstantSigns.end()) {
      result += sign->second;
      at += sign->first.size();
    } else if (std::string_view("0123456789.+-*/()^ ").find(c) != std::string_view::npos) {
      hasValue = hasValue || std::isdigit(static_cast<unsigned char>(c)) != 0;
      result += c;
      ++at;
    } else {
      return std::nullopt;
    }
  }
  return hasValue ? std::optional(result) : std::nullopt;
}

}  // namespace

std::map<std::string, std::string> textbookConstants(const std::vector<TextPiece>& statements) {
  std::set<std::string> used;
  for (const TextPiece& statement : statements) {
    const auto setting = settingOf(statement);
    if (arrowOf(statement.text) || (setting && setting->setting == Setting::Axiom)) {
      addUsedNames(statement, used);
    }
  }
  std::map<std::string, std::string> constants;
  std::map<std::string, std::string> all;
  for (const TextPiece& statement : statements) {
    if (arrowOf(statement.text)) {
      continue;
    }
    const bool isMacro = statement.text.starts_with("#define");
    // `constants: r = 2`
    const auto list = settingOf(statement);
    const bool isListed =
        list && list->setting == Setting::Sets && list->value.text.find('=') != std::string_view::npos;
    const TextPiece definition = isMacro    ? statement.from(std::string_view("#define").size()).trimmed()
                                 : isListed ? list->value
                                            : statement;
    std::size_t at = 0;
    const std::string name = readTextbookName(definition.text, at);
    TextPiece value = definition.from(at).trimmed();
    if (name.empty() || (!isMacro && !value.text.starts_with('=') && !value.text.starts_with(':'))) {
      continue;
    }
    value = isMacro ? value : value.from(1).trimmed();
    if (const auto text = constantText(value.text, all)) {
      all[name] = *text;
      if (used.contains(name)) {
        constants[name] = *text;
      }
    }
  }
  return constants;
}

}  // namespace espalier::language

#include "engine/language/dialects/textbook.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "engine/language/dialects/painter_objects.h"
#include "engine/language/dialects/text_lines.h"
#include "engine/language/dialects/textbook_modules.h"

namespace espalier::language {
namespace {

constexpr std::array<std::string_view, 5> kArrows{"→", "⟶", "-->", "->", "⇒"};
constexpr double kMostSteps = 1e6;
constexpr double kProbabilityTolerance = 0.0101;  // a third may be printed as 0.33
constexpr std::string_view kShape = "shape ";

enum class Setting : std::uint8_t { Axiom, Angle, Steps, Heading, Step, Turns, Productions, Sets };

struct SettingName {
  std::string_view name;  // small letters
  Setting setting;
};

constexpr std::array kSettings = {
    SettingName{"ω", Setting::Axiom},         SettingName{"w", Setting::Axiom},
    SettingName{"omega", Setting::Axiom},     SettingName{"axiom", Setting::Axiom},
    SettingName{"axioma", Setting::Axiom},    SettingName{"axiomat", Setting::Axiom},
    SettingName{"l", Setting::Axiom},         SettingName{"α", Setting::Axiom},
    SettingName{"wm", Setting::Axiom},        SettingName{"wd", Setting::Axiom},
    SettingName{"δ", Setting::Angle},         SettingName{"delta", Setting::Angle},
    SettingName{"angle", Setting::Angle},     SettingName{"b", Setting::Angle},
    SettingName{"n", Setting::Steps},         SettingName{"steps", Setting::Steps},
    SettingName{"iteracja", Setting::Steps},  SettingName{"derivation length", Setting::Steps},
    SettingName{"α0", Setting::Heading},      SettingName{"alpha0", Setting::Heading},
    SettingName{"heading", Setting::Heading}, SettingName{"d", Setting::Step},
    SettingName{"turns", Setting::Turns},     SettingName{"p", Setting::Productions},
    SettingName{"pm", Setting::Productions},  SettingName{"pd", Setting::Productions},
    SettingName{"v", Setting::Sets},          SettingName{"g", Setting::Sets},
    SettingName{"a", Setting::Sets},          SettingName{"gm", Setting::Sets},
    SettingName{"gd", Setting::Sets},         SettingName{"alphabet", Setting::Sets},
};

// place and length of the first arrow
std::optional<std::pair<std::size_t, std::size_t>> arrowOf(std::string_view text) {
  std::optional<std::pair<std::size_t, std::size_t>> first;
  for (const std::string_view arrow : kArrows) {
    const std::size_t at = text.find(arrow);
    if (at != std::string_view::npos && (!first || at < first->first)) {
      first = {at, arrow.size()};
    }
  }
  return first;
}

// a line without its remark
TextPiece withoutRemark(const TextPiece& line) {
  const std::size_t slashes = std::min(line.text.find("//"), line.text.find("/*"));
  // in a string of modules two slashes are two rolls: a remark stands after blanks, or alone
  const bool isRemark =
      slashes == 0 || (slashes != std::string_view::npos && line.text[slashes - 1] == ' ' && !arrowOf(line.text));
  return (isRemark ? line.to(slashes) : line).trimmed();
}

// statements: lines; a line that begins with an arrow is joined to the line before
std::vector<TextPiece> statementsOf(std::string_view text) {
  std::vector<TextPiece> statements;
  for (const TextPiece& line : linesOf(text)) {
    const TextPiece code = withoutRemark(line);
    if (code.empty()) {
      continue;
    }
    const auto arrow = arrowOf(code.text);
    if (arrow && arrow->first == 0 && !statements.empty() && !arrowOf(statements.back().text)) {
      TextPiece& last = statements.back();
      last.text = text.substr(last.offset, code.offset + code.text.size() - last.offset);
    } else {
      statements.push_back(code);
    }
  }
  return statements;
}

struct NamedValue {
  Setting setting = Setting::Sets;
  TextPiece value;
};

// `name: value` or `name = value` of a known name; a subscript 0 belongs to the name
std::optional<NamedValue> settingOf(const TextPiece& statement) {
  std::size_t at = statement.text.find_first_of(":=");
  if (at == std::string_view::npos) {
    return std::nullopt;
  }
  std::string name = lowered(statement.to(at).trimmed().text);
  for (const std::string_view zero : {"_0", "_{0}", "₀"}) {
    if (name.ends_with(zero)) {
      name.replace(name.size() - zero.size(), zero.size(), "0");
    }
  }
  const auto found =
      std::find_if(kSettings.begin(), kSettings.end(), [&](const auto& entry) { return entry.name == name; });
  if (found == kSettings.end()) {
    return std::nullopt;
  }
  const TextPiece value = statement.from(at + 1).trimmed();
  // α is a heading when it is a number
  const bool isHeading = found->name == "α" && textbookNumber(value.text).has_value();
  return NamedValue{isHeading ? Setting::Heading : found->setting, value};
}

// the axioms of a set `L,R`: commas outside parentheses, each between two symbols
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
  for (const TextPiece& statement : statementsOf(text)) {
    const auto setting = arrowOf(statement.text) ? std::nullopt : settingOf(statement);
    if (setting && setting->setting == Setting::Axiom) {
      return setting;
    }
  }
  return std::nullopt;
}

// `p1:`, `p:` or `P:` before a production
TextPiece withoutLabel(const TextPiece& statement) {
  const std::size_t colon = statement.text.find(':');
  const auto arrow = arrowOf(statement.text);
  if (colon == std::string_view::npos || (arrow && arrow->first < colon)) {
    return statement;
  }
  std::size_t at = 0;
  const TextPiece label = statement.to(colon).trimmed();
  if (label.empty() || lowered(label.text.front()) != 'p') {
    return statement;
  }
  at = 1;
  while (at < label.text.size() && std::isdigit(static_cast<unsigned char>(label.text[at])) != 0) {
    ++at;
  }
  (void)readSubscript(label.text, at);
  return at == label.text.size() ? statement.from(colon + 1).trimmed() : statement;
}

class TextbookReader {
 public:
  TextbookReader(std::string_view text, const TextbookExtension& extension, DialectReport& report)
      : text_(text),
        report_(report),
        modules_(report, symbols_, PainterSigns{extension.isTurtlePainter}),
        painter_(extension.isTurtlePainter, report) {}

  CpfgModel read(const std::string& entry) {
    for (const TextPiece& statement : statementsOf(text_)) {
      readStatement(statement, entry);
    }
    finish();
    return std::move(model_);
  }

 private:
  void readStatement(const TextPiece& statement, const std::string& entry) {
    if (statement.text.starts_with('#')) {
      return readDirective(statement);
    }
    if (painter_.reads(statement)) {
      return;
    }
    if (lowered(statement.text.substr(0, kShape.size())) == kShape) {
      return readShape(statement.from(kShape.size()).trimmed());
    }
    if (const auto arrow = arrowOf(statement.text)) {
      const auto setting = settingOf(statement);
      const bool isSet = setting && setting->setting == Setting::Productions && setting->value.text.starts_with('{');
      return isSet ? readProductionSet(setting->value) : readProduction(withoutLabel(statement));
    }
    const std::size_t equals = statement.text.find('=');
    if (equals != std::string_view::npos) {
      const TextPiece left = withoutLabel(statement).to(withoutLabel(statement).text.find('='));
      if (const auto head = TextbookModules::levelled(left)) {
        const TextPiece rule = withoutLabel(statement);
        return addRecurrence(*head, left, rule.from(rule.text.find('=') + 1).trimmed());
      }
      if (readMeaning(statement, equals)) {
        return;
      }
    }
    if (const auto setting = settingOf(statement)) {
      return readSetting(*setting, statement, entry);
    }
    if (const auto degrees = textbookNumber(statement.text); degrees && statement.text.ends_with("°")) {
      model_.angleDegrees = *degrees;
      hasAngle_ = true;
      return;
    }
    report_.error(
        statement.offset, statement.text.size(),
        "expected an axiom, a production or a setting, found '" + std::string(statement.text.substr(0, 40)) + "'",
        "write 'ω: F', 'p1: F → F+F', 'δ = 60°', 'n = 3', 'd = 1', '#ignore: +-'");
  }

  // `shape X: modules`: the drawing of a symbol; for a bracket, too, so that brackets need no partner in it
  void readShape(const TextPiece& shape) {
    const std::size_t colon = shape.text.find(':');
    if (colon == std::string_view::npos || shape.to(colon).trimmed().empty()) {
      report_.error(shape.offset, shape.text.size(), "expected a module and ':' while reading 'shape'",
                    "write 'shape L: [+(30)F]': L is drawn so");
      return;
    }
    TextbookSymbols unused;
    TextbookModules modules(report_, unused, PainterSigns{});
    const MappedText successor = modules.modules(shape.from(colon + 1));
    MappedText text = modules.modules(shape.to(colon));
    text.make(" --> ", shape.offset).add(successor.empty() ? MappedText("*", shape.offset) : successor);
    model_.drawing.push_back(std::move(text));
  }

  void readDirective(const TextPiece& statement) {
    const TextPiece word = statement.from(1).trimmed();
    for (const std::string_view name : {"ignore", "consider"}) {
      if (!word.text.starts_with(name)) {
        continue;
      }
      TextPiece list = word.from(name.size()).trimmed();
      list = list.text.starts_with(':') ? list.from(1) : list;
      MappedText item(std::string(name) + ": ", statement.offset);
      for (std::size_t i = 0; i < list.text.size(); ++i) {
        if (list.text[i] != ' ' && list.text[i] != ',') {
          item.copy(list.text.substr(i, 1), list.offset + i);
        }
      }
      model_.items.push_back(std::move(item));
      return;
    }
    if (word.text.starts_with("define")) {
      model_.items.push_back(MappedText().copy(statement.text, statement.offset));
    }
    // other lines with # are remarks
  }

  void readSetting(const NamedValue& setting, const TextPiece& statement, const std::string& entry) {
    if (setting.setting == Setting::Sets) {
      return;
    }
    if (setting.value.empty()) {
      report_.error(statement.offset, statement.text.size(), "a setting without a value", "write it behind the name");
      return;
    }
    switch (setting.setting) {
      case Setting::Axiom:
        return readAxiom(setting.value, entry);
      case Setting::Productions:
        return readProductionSet(setting.value);
      case Setting::Turns:
        isClockwise_ = lowered(setting.value.text) == "clockwise";
        if (!isClockwise_ && lowered(setting.value.text) != "counterclockwise") {
          report_.error(setting.value.offset, setting.value.text.size(),
                        "expected 'clockwise' or 'counterclockwise', found '" + std::string(setting.value.text) + "'",
                        "it sets the direction in which + turns");
        }
        return;
      case Setting::Step:
        return readStep(setting.value);
      default:
        break;
    }
    const std::optional<double> number = textbookNumber(setting.value.text);
    if (setting.setting == Setting::Steps) {
      if (!number || *number < 0.0 || *number != std::floor(*number) || *number > kMostSteps) {
        report_.error(setting.value.offset, setting.value.text.size(),
                      "expected a whole number from 0 to 1000000 while reading n, found '" +
                          std::string(setting.value.text.substr(0, 40)) + "'",
                      "it says how many steps are derived");
        return;
      }
      steps_ = static_cast<std::uint64_t>(*number);
      return;
    }
    if (!number) {
      report_.error(setting.value.offset, setting.value.text.size(),
                    "expected an angle in degrees, found '" + std::string(setting.value.text.substr(0, 40)) + "'",
                    "write it as δ = 25.7°");
      return;
    }
    if (setting.setting == Setting::Heading) {
      model_.headingDegrees = *number;
    } else {
      model_.angleDegrees = *number;
      hasAngle_ = true;
    }
  }

  // `4`, or `d/4`: a step of the next generation is a quarter as long
  void readStep(const TextPiece& value) {
    const bool isQuotient = value.text.starts_with("d/");
    const auto number = textbookNumber(isQuotient ? value.text.substr(2) : value.text);
    if (!number || !(*number > 0.0)) {
      report_.error(
          value.offset, value.text.size(),
          "expected a length or a quotient such as d/4, found '" + std::string(value.text.substr(0, 40)) + "'",
          "d is the length of a step");
      return;
    }
    (isQuotient ? divisor_ : step_) = *number;
  }

  void readAxiom(const TextPiece& value, const std::string& entry) {
    TextPiece chosen = value;
    const std::vector<TextPiece> axioms = axiomsOf(value);
    for (const TextPiece& axiom : axioms) {
      if (axioms.size() == 1 || axiom.text == entry) {
        chosen = axiom;
      }
    }
    checkBrackets(text_, chosen.offset, chosen.offset + chosen.text.size(), "the axiom", report_);
    model_.axiom = modules_.modules(chosen);
  }

  // `F_a = |`: how a symbol with a named subscript is drawn, by the number of lines
  bool readMeaning(const TextPiece& statement, std::size_t equals) {
    const TextPiece left = statement.to(equals).trimmed();
    const TextPiece right = statement.from(equals + 1).trimmed();
    std::size_t at = 1;
    const Subscript subscript = left.empty() ? Subscript{} : readSubscript(left.text, at);
    const bool isBars = !right.empty() && right.text.find_first_not_of('|') == std::string_view::npos;
    if (subscript.kind != Subscript::Kind::Name || at != left.text.size() || !isBars) {
      return false;
    }
    widths_[std::string(1, left.text.front()) + "_" + subscript.name] = right.text.size();
    return true;
  }

  void readProductionSet(TextPiece value) {
    if (value.text.starts_with('{') && value.text.ends_with('}')) {
      value = value.from(1).to(value.text.size() - 2);
    }
    // a comma ends a production when an arrow follows before the next comma
    std::size_t begin = 0;
    int depth = 0;
    for (std::size_t at = 0; at <= value.text.size(); ++at) {
      const char c = at < value.text.size() ? value.text[at] : ',';
      depth += c == '(' ? 1 : c == ')' ? -1 : 0;
      const std::string_view behind = at < value.text.size() ? value.text.substr(at + 1) : std::string_view{};
      const auto arrow = arrowOf(behind);
      const bool isEnd =
          at == value.text.size() || (arrow && behind.substr(0, arrow->first).find(',') == std::string_view::npos);
      if (c == ',' && depth == 0 && isEnd) {
        const TextPiece production = TextPiece{value.text.substr(begin, at - begin), value.offset + begin}.trimmed();
        if (!production.empty()) {
          readProduction(production);
        }
        begin = at + 1;
      }
    }
  }

  // [left '<'] predecessor ['>' right] [':' condition] '→' ['(' probability ')'] successor [':' probability]
  void readProduction(const TextPiece& production) {
    const auto arrow = arrowOf(production.text);
    if (!arrow) {
      report_.error(
          production.offset, production.text.size(),
          "expected '→' while reading a production, found '" + std::string(production.text.substr(0, 40)) + "'",
          "a production is a predecessor, '→' and its successor");
      return;
    }
    const TextPiece left = production.to(arrow->first).trimmed();
    TextPiece right = production.from(arrow->first + arrow->second).trimmed();
    if (const auto head = TextbookModules::levelled(left)) {
      return addRecurrence(*head, left, right);
    }
    const TextPiece front = left.to(left.text.find(':')).trimmed();
    const bool isIdentity = front.text == right.text && (front.text == "[" || front.text == "]");
    if (isIdentity) {
      return;
    }
    modules_.setFormals(front);
    MappedText text = readPredecessor(front);
    if (left.text.find(':') != std::string_view::npos) {
      text.make(" : ", front.offset);
      text.add(modules_.expression(left.from(left.text.find(':') + 1).trimmed()));
    }
    // the probability in front, in parentheses, or behind a colon
    TextPiece written;
    if (right.text.starts_with('(') && right.text.find(')') != std::string_view::npos) {
      const std::size_t end = right.text.find(')');
      written = right.from(1).to(end - 1);
      right = right.from(end + 1).trimmed();
    } else if (const std::size_t colon = right.text.rfind(':'); colon != std::string_view::npos) {
      written = right.from(colon + 1).trimmed();
      right = right.to(colon).trimmed();
    }
    const MappedText probability = written.empty() ? MappedText{} : modules_.expression(written);
    noteProbability(left, written);
    checkBrackets(text_, right.offset, right.offset + right.text.size(), "the successor", report_);
    const MappedText successor = right.text == "*" ? MappedText{} : modules_.modules(right);
    text.make(" --> ", right.offset).add(successor.empty() ? MappedText("*", right.offset) : successor);
    if (!probability.empty()) {
      text.make(" : ", right.offset).add(probability);
      model_.isStochastic = true;
    }
    model_.productions.push_back(std::move(text));
  }

  // of productions with one left side that all have a number
  void noteProbability(const TextPiece& left, const TextPiece& written) {
    std::string side(left.text);
    std::erase(side, ' ');
    Chances& chances = chances_.try_emplace(side, Chances{left, 0.0, true}).first->second;
    const std::optional<double> number = textbookNumber(written.text);
    chances.areNumbers = chances.areNumbers && number;
    chances.sum += number.value_or(0.0);
    if (number && *number < 0.0) {
      report_.error(written.offset, written.text.size(),
                    "a probability is a number from 0 to 1, found '" + std::string(written.text.substr(0, 40)) + "'",
                    "write it behind the production, as in 'F → F[+F]F : 0.33', or before it, as in 'F → (1/3)F[+F]F'");
    }
  }

  // not an error: weights with another sum than 1 are scaled
  void checkProbabilities() {
    for (const auto& [side, chances] : chances_) {
      if (chances.areNumbers && std::abs(chances.sum - 1.0) > kProbabilityTolerance) {
        report_.warn(chances.first.offset, chances.first.text.size(),
                     "the probabilities of " + side + " sum to " + cpfgNumber(std::round(chances.sum * 1e6) / 1e6),
                     "they are scaled to 1");
      }
    }
  }

  MappedText readPredecessor(const TextPiece& front) {
    MappedText text;
    std::size_t begin = 0;
    for (std::size_t at = 0; at < front.text.size(); ++at) {
      const char c = front.text[at];
      const bool isInside = std::count(front.text.begin(), front.text.begin() + static_cast<std::ptrdiff_t>(at), '(') >
                            std::count(front.text.begin(), front.text.begin() + static_cast<std::ptrdiff_t>(at), ')');
      if ((c != '<' && c != '>') || isInside) {
        continue;
      }
      text.add(modules_.modules({front.text.substr(begin, at - begin), front.offset + begin}));
      text.make(std::string(" ") + c + " ", front.offset + at);
      begin = at + 1;
      if (begin < front.text.size() && front.text[begin] == '=') {
        report_.warn(front.offset + at, 2, std::string("'") + c + "=' is read as '" + c + "'",
                     "contexts are written l < a > r");
        ++begin;
        at = begin - 1;
      }
    }
    if (front.from(begin).trimmed().empty()) {
      report_.error(front.offset, front.text.size(), "a production without a predecessor",
                    "the symbol that is replaced stands before '→'");
    }
    return text.add(modules_.modules(front.from(begin)));
  }

  // X_{n+1} = ..., x_n → ... and the rules of single levels, X_0 → ...
  void addRecurrence(const TextbookModules::Levelled& head, const TextPiece& left, const TextPiece& right) {
    checkBrackets(text_, right.offset, right.offset + right.text.size(), "the recurrence", report_);
    const bool isLevel = head.subscript.kind == Subscript::Kind::Level;
    const int shift = isLevel ? head.subscript.shift : 0;
    const std::string plainName = head.name;
    const MappedText successor = modules_.modules(right, shift);
    symbols_.levelled.insert(head.name);
    const std::string condition = isLevel ? "n > 0" : "n == " + std::to_string(head.subscript.shift);
    MappedText rule(head.name + "(n) : " + condition + " --> ", left.offset);
    rule.add(successor.empty() ? MappedText("*", right.offset) : successor);
    const bool isBase = !isLevel && head.subscript.shift == 0;
    if (isBase) {
      // level 0 is drawn
      bases_.insert(head.name);
      model_.drawing.push_back(std::move(rule));
      return;
    }
    // a symbol that keeps its level is one step behind
    isBehind_ = isBehind_ || successor.text().find("(n)") != std::string::npos;
    if (firstRecurrence_.empty() || head.subscript.shift > highestLevel_) {
      firstRecurrence_ = firstRecurrence_.empty() || !isLevel ? head.name : firstRecurrence_;
    }
    highestLevel_ = isLevel ? highestLevel_ : std::max(highestLevel_, head.subscript.shift);
    recurrenceOffset_ = left.offset;
    model_.productions.push_back(std::move(rule));
  }

  void finish() {
    checkProbabilities();
    if (model_.axiom.empty() && !firstRecurrence_.empty()) {
      const auto level = steps_.value_or(static_cast<std::uint64_t>(std::max(1, highestLevel_)));
      model_.axiom.make(firstRecurrence_ + "(" + std::to_string(level) + ")", recurrenceOffset_);
      steps_ = level + (isBehind_ ? 1U : 0U);
    }
    if (model_.axiom.empty()) {
      report_.error(0, 1, "the model has no axiom", "write the first string as 'ω: F'");
    }
    const auto turns = [&](char symbol) { return symbols_.plain.count(symbol) > 0; };
    if (!hasAngle_ && (turns('+') || turns('-'))) {
      report_.note(0, 1, "the model turns with + or - and has no angle: it is taken as 45 degrees", "write 'δ = 60°'");
    }
    model_.derivationLength = steps_.value_or(1);
    if (!symbols_.names.empty()) {
      std::string names;
      for (const std::string& name : symbols_.names) {
        names += (names.empty() ? "" : ", ") + name;
      }
      model_.items.insert(model_.items.begin(), MappedText("Module: " + names, 0));
      model_.needs.push_back("symbols of more than one character: " + names);
    }
    addDrawing();
  }

  void addDrawing() {
    const std::string angle = "(" + cpfgNumber(model_.angleDegrees) + ")";
    const std::string length =
        step_ == 1.0 && divisor_ == 1.0
            ? std::string{}
            : "(" + cpfgNumber(step_) + (divisor_ == 1.0 ? "" : "/" + cpfgNumber(divisor_) + "^Q") + ")";
    const auto draw = [&](const std::string& symbol, const std::string& modules) {
      model_.drawing.emplace_back(symbol + " --> " + modules, 0);
    };
    if (!length.empty()) {
      draw("F", "F" + length);
      draw("f", "f" + length);
    }
    for (const std::string& name : symbols_.names) {
      const auto width = widths_.find(name);
      if (name.front() == 'F') {
        draw(name, width == widths_.end() || width->second == 1
                       ? "F" + length
                       : "#(" + std::to_string(width->second) + ")F" + length + "#(1)");
      }
    }
    for (const std::string& name : symbols_.levelled) {
      if (name == "F") {
        draw("F(n)", "F" + length);
      }
    }
    if (isClockwise_) {
      draw("+", "-" + angle);
      draw("-", "+" + angle);
    }
    const auto uses = [&](char symbol) { return symbols_.plain.count(symbol) > 0; };
    if (painter_.isActive()) {
      return painter_.addDrawing(symbols_.plain, model_);
    }
    // the chapter's matrices roll in the opposite direction
    if (uses('/')) {
      draw("/", "\\" + angle);
    }
    if (uses('\\')) {
      draw("\\", "/" + angle);
    }
    // thicker, and the next colour
    if (uses('!')) {
      draw("!", "#");
      model_.viewCommands.emplace_back("line width increment: 1");
    }
    if (uses(',')) {
      draw(",", ";");
      model_.viewCommands.emplace_back("color increment: 20");
    }
  }

  // the probabilities of the productions with one left side
  struct Chances {
    TextPiece first;  // left side of the first of them
    double sum = 0.0;
    bool areNumbers = true;  // each of them has one
  };

  std::string_view text_;
  DialectReport& report_;
  CpfgModel model_;
  std::map<std::string, Chances> chances_;  // by left side without blanks
  TextbookSymbols symbols_;
  TextbookModules modules_;
  PainterObjects painter_;
  std::map<std::string, std::size_t> widths_;  // lines in the sign of a named symbol
  std::set<std::string> bases_;                // recurrences with a rule for level 0
  std::string firstRecurrence_;
  int highestLevel_ = 0;
  std::size_t recurrenceOffset_ = 0;
  bool isBehind_ = false;
  bool isClockwise_ = false;
  bool hasAngle_ = false;
  std::optional<std::uint64_t> steps_;
  double step_ = 1.0;
  double divisor_ = 1.0;
};

}  // namespace

bool recognisesTextbook(std::string_view text) {
  bool hasArrow = false;
  for (const TextPiece& statement : statementsOf(text)) {
    const bool isStart = !arrowOf(statement.text) && settingOf(statement) &&
                         (statement.text.starts_with("ω") || lowered(statement.text).starts_with("w"));
    if (isStart || statement.text.find("→") != std::string_view::npos ||
        statement.text.find("⟶") != std::string_view::npos) {
      return true;
    }
    const std::size_t equals = statement.text.find('=');
    if (equals != std::string_view::npos && TextbookModules::levelled(statement.to(equals))) {
      return true;
    }
    const std::size_t arrow = statement.text.find("->");
    hasArrow = hasArrow || (arrow != std::string_view::npos && arrow > 0 && statement.text[arrow - 1] != '-');
  }
  // without an axiom, too: cpfg's arrow is longer
  return hasArrow && (axiomOf(text).has_value() || text.find("-->") == std::string_view::npos);
}

std::vector<DialectEntry> textbookEntries(std::string_view text) {
  const std::optional<NamedValue> axiom = axiomOf(text);
  std::vector<DialectEntry> entries;
  if (axiom) {
    const std::vector<TextPiece> axioms = axiomsOf(axiom->value);
    for (const TextPiece& piece : axioms) {
      if (axioms.size() > 1) {
        entries.push_back({std::string(piece.text), piece.offset});
      }
    }
  }
  return entries;
}

CpfgModel translateTextbookWith(std::string_view text, const std::string& entry, const TextbookExtension& extension,
                                DialectReport& report) {
  return TextbookReader(text, extension, report).read(entry);
}

CpfgModel translateTextbook(std::string_view text, const std::string& entry, DialectReport& report) {
  return translateTextbookWith(text, entry, {}, report);
}

}  // namespace espalier::language

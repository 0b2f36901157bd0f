#include "engine/language/dialects/textbook/textbook.h"

#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "engine/language/dialects/painter_objects.h"
#include "engine/language/dialects/text_lines.h"
#include "engine/language/dialects/textbook/textbook_modules.h"
#include "engine/language/dialects/textbook/textbook_signs.h"
#include "engine/language/dialects/textbook/textbook_statements.h"
#include "engine/language/dialects/textbook/textbook_words.h"
#include "engine/language/parse/foreign_lines.h"

namespace espalier::language {
namespace {

constexpr double kMostSteps = 1e6;
constexpr double kProbabilityTolerance = 0.0101;  // a third may be printed as 0.33
constexpr const char* kLines = "write 'ω: F', 'p1: F → F+F', 'δ = 60°', 'n = 3', 'd = 1', '#ignore: +-'";
constexpr std::string_view kShape = "shape ";

class TextbookReader {
 public:
  TextbookReader(std::string_view text, const TextbookExtension& extension, DialectReport& report)
      : plain_(plainTextbook(text)),
        text_(plain_),
        report_(report),
        modules_(report, symbols_, PainterSigns{extension.isTurtlePainter}),
        painter_(extension.isTurtlePainter, report) {}

  CpfgModel read(const std::string& entry) {
    const std::vector<TextPiece> statements = textbookStatements(text_);
    modules_.setConstants(textbookConstants(statements));
    symbols_.words = textbookWords(statements);
    hasNamedAxiom_ = axiomOf(text_).has_value();
    for (const TextPiece& statement : statements) {
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
    if (arrowOf(statement.text)) {
      const auto setting = settingOf(statement);
      if (!setting || setting->setting != Setting::Productions) {
        return readProductionSet(withoutLabel(statement));
      }
      // `Rule 1: F -> FF`
      const std::size_t number = setting->value.text.find_first_not_of("0123456789");
      const bool isNumbered = number != 0 && number != std::string_view::npos && setting->value.text[number] == ':';
      return readProductionSet(isNumbered ? setting->value.from(number + 1).trimmed() : setting->value);
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
    std::size_t at = 0;
    const std::string name = readTextbookName(statement.text, at);
    if (modules_.isConstant(name)) {
      return;
    }
    if (const auto degrees = textbookNumber(statement.text);
        degrees && (statement.text.ends_with("°") || statement.text.ends_with("◦"))) {
      model_.angleDegrees = *degrees;
      hasAngle_ = true;
      return;
    }
    // the axiom of a caption stands alone on its line
    if (!hasNamedAxiom_ && model_.productions.empty() && isModules(statement.text)) {
      report_.note(statement.offset, statement.text.size(),
                   "'" + std::string(statement.text.substr(0, 40)) + "' is read as the axiom",
                   "write 'ω: F' to name the axiom");
      model_.axiom = {};
      return readAxiom(statement, entry);
    }
    readOtherLine(statement);
  }

  // a line without `:`, `=` and blanks between words, with the letters and signs of modules
  static bool isModules(std::string_view text) {
    const bool hasSigns = text.find_first_of(":=\"?!;") != std::string_view::npos;
    return !hasSigns && !isProse(text) &&
           std::any_of(text.begin(), text.end(),
                       [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }) &&
           (text.size() <= 2 || text.find_first_of("+-[(&^/") != std::string_view::npos ||
            std::none_of(text.begin(), text.end(),
                         [](char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }));
  }

  void readOtherLine(const TextPiece& statement) {
    const std::string shown(statement.text.substr(0, 40));
    if (const auto degrees = angleOfSentence(statement.text)) {
      report_.note(statement.offset, statement.text.size(), "'" + shown + "' is read as the angle",
                   "write 'δ = " + cpfgNumber(*degrees) + "°'");
      model_.angleDegrees = *degrees;
      hasAngle_ = true;
      return;
    }
    const std::size_t mark = statement.text.find_first_of(":=");
    const std::string_view near = mark == std::string_view::npos
                                      ? std::string_view{}
                                      : nearestSetting(lowered(statement.to(mark).trimmed().text));
    if (!near.empty()) {
      report_.error(statement.offset, mark,
                    "there is no setting '" + std::string(statement.to(mark).trimmed().text) + "'",
                    "did you mean '" + std::string(near) + "'?");
    } else if (mark != std::string_view::npos && textbookNumber(statement.from(mark + 1).text)) {
      report_.warn(statement.offset, mark, "nothing in the model uses '" + shown + "'",
                   "use the name or remove the line");
    } else if (isProse(statement.text) || statement.text.ends_with(':')) {
      report_.warn(statement.offset, statement.text.size(), "'" + shown + "' is read as a remark",
                   "begin remarks with '#'");
    } else {
      report_.error(statement.offset, statement.text.size(),
                    "expected an axiom, a production or a setting, found '" + shown + "'",
                    latexCommand(statement.text).empty() ? kLines : latexAdvice(latexCommand(statement.text)));
    }
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
    const MappedText successor = modules.modules(shape.from(colon + 1), 0, !painter_.isActive());
    MappedText text = modules.modules(shape.to(colon));
    text.make(" --> ", shape.offset).add(successor.empty() ? MappedText("*", shape.offset) : successor);
    model_.drawing.push_back(std::move(text));
  }

  void readDirective(const TextPiece& statement) {
    const TextPiece word = statement.from(1).trimmed();
    for (const std::string_view name : {"ignore", "consider"}) {
      if (word.text.starts_with(name)) {
        TextPiece list = word.from(name.size()).trimmed();
        list = list.text.starts_with(':') ? list.from(1) : list;
        return addSymbolList(name, list);
      }
    }
    if (const std::string advice = directiveAdvice(word.text, text_); !advice.empty()) {
      return report_.warn(statement.offset, statement.text.size(),
                          "'" + std::string(statement.text) + "' has no effect in textbook notation", advice);
    }
    if (word.text.starts_with("define")) {
      const TextPiece macro = word.from(std::string_view("define").size()).trimmed();
      std::size_t at = 0;
      const std::string name = readTextbookName(macro.text, at);
      const TextPiece value = macro.from(at).trimmed();
      const auto setting = settingOf({std::string(macro.to(at).text) + ":", 0});
      if (setting && setting->setting == Setting::Steps && textbookNumber(value.text)) {
        readSteps(value);
      } else if (setting && setting->setting == Setting::Angle && !modules_.isConstant(name) &&
                 textbookNumber(value.text)) {
        model_.angleDegrees = *textbookNumber(value.text);
        hasAngle_ = true;
      } else if (!modules_.isConstant(name)) {
        const std::size_t front = statement.text.size() - value.text.size();
        model_.items.push_back(
            MappedText().copy(statement.text.substr(0, front), statement.offset).add(modules_.expression(value)));
      }
    }
    // other lines with # are remarks
  }

  void addSymbolList(std::string_view name, const TextPiece& list) {
    MappedText item(std::string(name) + ": ", list.offset);
    for (std::size_t i = 0; i < list.text.size(); ++i) {
      if (list.text[i] != ' ' && list.text[i] != ',') {
        item.copy(list.text.substr(i, 1), list.offset + i);
      }
    }
    model_.items.push_back(std::move(item));
  }

  void readSteps(const TextPiece& value) {
    const std::optional<double> number = textbookNumber(value.text);
    if (!number || *number < 0.0 || *number != std::floor(*number) || *number > kMostSteps) {
      report_.error(value.offset, value.text.size(),
                    "expected a whole number from 0 to 1000000 while reading n, found '" +
                        std::string(value.text.substr(0, 40)) + "'",
                    "it says how many steps are derived");
      return;
    }
    steps_ = static_cast<std::uint64_t>(*number);
  }

  void readSetting(const NamedValue& setting, const TextPiece& statement, const std::string& entry) {
    if (setting.setting == Setting::Sets) {
      return;
    }
    if (setting.value.empty() && setting.setting == Setting::Productions) {
      return;  // a heading: the productions follow
    }
    // a name of one letter that expressions use is a constant: `d = 137.5`
    const bool isLetter = setting.name != "n" && setting.name != "δ" && setting.name != "θ" && setting.name.size() <= 2;
    std::size_t at = 0;
    if (isLetter && modules_.isConstant(readTextbookName(statement.text, at))) {
      return;
    }
    if (setting.value.empty()) {
      report_.error(statement.offset, statement.text.size(), "a setting without a value", "write it behind the name");
      return;
    }
    if (setting.setting == Setting::Steps && isDerivedString(setting.value.text)) {
      if (!std::exchange(hasDerivedStrings_, true)) {
        report_.note(statement.offset, statement.text.size(), "lines such as 'n = 1 : AB' show strings of the model",
                     "they are skipped; 'n = 4' sets the number of steps");
      }
      return;
    }
    const bool isOne = setting.setting == Setting::Axiom || setting.setting == Setting::Steps ||
                       (setting.setting == Setting::Angle && setting.name != "α");
    if (isOne && !isSet_.insert(setting.setting).second) {
      report_.warn(statement.offset, statement.text.size(), "'" + setting.name + "' is given once more",
                   "the last one counts; remove the others");
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
      case Setting::Steps:
        return readSteps(setting.value);
      case Setting::Ignore:
        return addSymbolList("ignore", setting.value);
      case Setting::Consider:
        return addSymbolList("consider", setting.value);
      default:
        break;
    }
    const std::optional<double> number = textbookNumber(setting.value.text);
    if (!number) {
      report_.error(setting.value.offset, setting.value.text.size(),
                    "expected an angle in degrees, found '" + std::string(setting.value.text.substr(0, 40)) + "'",
                    "write it as δ = 25.7°");
      return;
    }
    if (setting.setting == Setting::Heading) {
      model_.headingDegrees = *number;
    } else if (setting.name == "α") {
      alpha_ = number;
    } else {
      model_.angleDegrees = *number;
      hasAngle_ = true;
    }
  }

  // `0 : A`, a line of a list of the strings of all steps, which begins with 0 or 1
  [[nodiscard]] bool isDerivedString(std::string_view value) const {
    const std::size_t mark = std::min(value.find_first_not_of("0123456789 "), value.size());
    const std::string_view number = value.substr(0, value.find_first_of(" :"));
    return mark > 0 && value.substr(mark).starts_with(':') && (hasDerivedStrings_ || number == "0" || number == "1");
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

  void readProductionSet(const TextPiece& value) {
    for (const TextPiece& production : productionsOf(value)) {
      readProduction(withoutLabel(production));
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
    TextPiece left = production.to(arrow->first).trimmed();
    TextPiece right = production.from(arrow->first + arrow->second).trimmed();
    if (const auto head = TextbookModules::levelled(left)) {
      return addRecurrence(*head, left, right);
    }
    const bool isJoined = arrow->first > 0 && production.text[arrow->first - 1] != ' ';
    TextPiece written = takeProbability(left, isJoined);
    const std::size_t mark = conditionMark(left.text);
    const TextPiece front = withoutAnyContext(left.to(mark).trimmed());
    const bool isIdentity = front.text == right.text && (front.text == "[" || front.text == "]");
    if (isIdentity) {
      return;
    }
    modules_.setFormals(front);
    MappedText text = readPredecessor(front);
    const TextPiece condition = mark == std::string_view::npos ? TextPiece{} : left.from(mark + 1).trimmed();
    if (!condition.empty() && condition.text != "*") {
      text.make(" : ", front.offset);
      text.add(modules_.condition(condition));
    }
    // the probability before the arrow, in front of the successor, in parentheses, or behind a colon
    if (!written.empty()) {
      // read already
    } else if (written = takeFrontProbability(right); !written.empty()) {
      // read now
    } else if (written = takeEndProbability(right); !written.empty()) {
      // read now
    } else if (right.text.starts_with('(') && right.text.find(')') != std::string_view::npos) {
      const std::size_t end = right.text.find(')');
      written = right.from(1).to(end - 1);
      right = right.from(end + 1).trimmed();
    } else if (const std::size_t colon = right.text.rfind(':'); colon != std::string_view::npos) {
      written = right.from(colon + 1).trimmed();
      right = right.to(colon).trimmed();
    }
    MappedText probability;
    if (written.text.ends_with('%') && textbookNumber(written.text)) {
      probability.make(cpfgNumber(*textbookNumber(written.text)), written.offset);
    } else if (!written.empty()) {
      probability = modules_.condition(written);
    }
    noteProbability(left, written);
    checkBrackets(text_, right.offset, right.offset + right.text.size(), "the successor", report_);
    if (const std::size_t bar = right.text.find(" | "); bar != std::string_view::npos) {
      report_.warn(right.offset + bar + 1, 1, "'|' turns the turtle around here",
                   "write each alternative as a production of its own: 'A → B' and 'A → C'");
    }
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
      const std::string_view rest = front.text.substr(at);
      const bool isSign = rest.starts_with("≤") || rest.starts_with("≥");
      const char c = !isSign ? rest.front() : rest.starts_with("≤") ? '<' : '>';
      const bool isInside = std::count(front.text.begin(), front.text.begin() + static_cast<std::ptrdiff_t>(at), '(') >
                            std::count(front.text.begin(), front.text.begin() + static_cast<std::ptrdiff_t>(at), ')');
      if ((c != '<' && c != '>') || isInside) {
        continue;
      }
      text.add(modules_.modules({front.text.substr(begin, at - begin), front.offset + begin}));
      text.make(std::string(" ") + c + " ", front.offset + at);
      const std::size_t length = isSign ? std::string_view("≤").size() : rest.substr(1).starts_with('=') ? 2 : 1;
      if (length > 1) {
        report_.warn(front.offset + at, length, "'" + std::string(rest.substr(0, length)) + "' is read as '" + c + "'",
                     "contexts are written l < a > r");
      }
      begin = at + length;
      at = begin - 1;
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
    const bool isBase = !isLevel && head.subscript.shift == 0;
    const MappedText successor = modules_.modules(right, shift, isBase);
    symbols_.levelled.insert(head.name);
    const std::string condition = isLevel ? "n > 0" : "n == " + std::to_string(head.subscript.shift);
    MappedText rule(head.name + "(n) : " + condition + " --> ", left.offset);
    rule.add(successor.empty() ? MappedText("*", right.offset) : successor);
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
    if (alpha_) {
      (hasAngle_ ? model_.headingDegrees : model_.angleDegrees) = *alpha_;
      hasAngle_ = true;
    }
    if (model_.axiom.empty() && !firstRecurrence_.empty()) {
      const auto level = steps_.value_or(static_cast<std::uint64_t>(std::max(1, highestLevel_)));
      model_.axiom.make(firstRecurrence_ + "(" + std::to_string(level) + ")", recurrenceOffset_);
      steps_ = level + (isBehind_ ? 1U : 0U);
    }
    if (model_.axiom.empty()) {
      report_.error(0, 1, "the model has no axiom", "write the first string as 'ω: F'");
    }
    const auto turns = [&](char symbol) { return symbols_.plain.count(symbol) > 0; };
    drawLettersOfNothing();
    if (!hasAngle_ && (turns('+') || turns('-'))) {
      report_.note(0, 1, "the model turns with + or - and has no angle: it is taken as 45 degrees", "write 'δ = 60°'");
    }
    model_.derivationLength = steps_.value_or(1);
    if (!symbols_.names.empty() || !symbols_.words.empty()) {
      std::string names;
      for (const std::string& name : symbols_.names) {
        names += (names.empty() ? "" : ", ") + name;
      }
      for (const std::string& word : symbols_.words) {
        names += (names.empty() ? "" : ", ") + word + "(...)";
      }
      model_.items.insert(model_.items.begin(), MappedText("Module: " + names, 0));
      model_.needs.push_back("symbols of more than one character: " + names);
    }
    addDrawing();
  }

  // in a model that turns and has no symbol of the turtle's that draws, every rewritten capital letter is a step
  void drawLettersOfNothing() {
    const auto uses = [&](std::string_view symbols) {
      return std::any_of(symbols.begin(), symbols.end(), [&](char c) { return symbols_.all.count(c) > 0; });
    };
    if (!uses("+-") || uses("FGfg{~@") || !symbols_.names.empty() || !symbols_.levelled.empty() || symbols_.hasLeaf ||
        !model_.drawing.empty() || painter_.isActive()) {
      return;
    }
    std::string letters;
    for (const char c : symbols_.plain) {
      if (c >= 'A' && c <= 'Z') {
        letters += std::string(letters.empty() ? "" : ", ") + c;
        drawnLetters_.insert(c);
      }
    }
    if (!letters.empty()) {
      report_.note(0, 1, "no symbol of the model draws: " + letters + " are drawn as steps",
                   "'shape A: F' gives the drawing of a symbol");
    }
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
    for (const char symbol : drawnLetters_) {
      draw(std::string(1, symbol), "F" + length);
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
    const auto uses = [&](char symbol) { return symbols_.plain.count(symbol) > 0; };
    const auto exchange = [&](char a, char b) {
      for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
        if (uses(from)) {
          draw(std::string(1, from), to + angle);
        }
        if (symbols_.numbered.count(from) > 0) {
          draw(from + std::string("(x)"), to + std::string("(x)"));
        }
      }
    };
    if (isClockwise_) {
      exchange('+', '-');
    }
    if (painter_.isActive()) {
      return painter_.addDrawing(symbols_.plain, model_);
    }
    // the chapter's matrices roll in the opposite direction
    exchange('/', '\\');
    // an apostrophe, the next colour of ABOP: the symbols are those of that book
    if (uses('\'')) {
      draw("'", ";");
      model_.viewCommands.emplace_back("color increment: 20");
      if (uses('!')) {
        model_.ownDrawing.emplace_back("! --> @W(0.7)", 0);
        model_.lost.emplace_back("that ! makes lines thinner");
      }
      return;
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

  std::string plain_;
  std::string_view text_;  // the plain text
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
  bool hasNamedAxiom_ = false;
  bool hasDerivedStrings_ = false;
  std::set<Setting> isSet_;  // of those that a model has once
  std::set<char> drawnLetters_;
  bool isBehind_ = false;
  bool isClockwise_ = false;
  bool hasAngle_ = false;
  std::optional<double> alpha_;  // the angle of turns, or the heading beside another angle
  std::optional<std::uint64_t> steps_;
  double step_ = 1.0;
  double divisor_ = 1.0;
};

}  // namespace

bool recognisesTextbook(std::string_view original) {
  const std::string text = plainTextbook(original);
  bool hasArrow = false;
  bool hasOwnSetting = false;  // that models of cpfg do not have
  for (const TextPiece& statement : textbookStatements(text)) {
    const auto arrow = arrowOf(statement.text);
    const auto setting = arrow ? std::nullopt : settingOf(statement);
    const bool isStart = setting && (statement.text.starts_with("ω") || lowered(statement.text).starts_with("w"));
    hasOwnSetting = hasOwnSetting || (setting && setting->name.size() > 2 && setting->name != "axiom" &&
                                      (setting->setting == Setting::Axiom || setting->setting == Setting::Angle));
    // every arrow but those of ASCII is none of cpfg's
    const bool isPrinted = arrow && statement.text[arrow->first] != '-';
    if (isStart || isPrinted) {
      return true;
    }
    const std::size_t equals = statement.text.find('=');
    if (equals != std::string_view::npos && TextbookModules::levelled(statement.to(equals))) {
      return true;
    }
    const std::size_t ascii = statement.text.find("->");
    hasArrow = hasArrow || (ascii != std::string_view::npos && ascii > 0 && statement.text[ascii - 1] != '-');
  }
  // without an axiom, too: cpfg's arrow is longer
  const bool hasLongArrow = text.find("-->") != std::string_view::npos;
  return hasLongArrow ? axiomOf(text) && (hasArrow || hasOwnSetting) : hasArrow;
}

std::vector<DialectEntry> textbookEntries(std::string_view original) {
  const std::string text = plainTextbook(original);
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

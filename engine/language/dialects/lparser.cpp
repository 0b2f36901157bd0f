#include "engine/language/dialects/lparser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/language/dialects/text_lines.h"

namespace espalier::language {
namespace {

constexpr std::array<std::string_view, 8> kWords{"recursion", "angle",     "thickness", "min_thickness",
                                                 "shape",     "switch_yz", "axiom",     "rule"};
constexpr double kMostRecursion = 1e6;
constexpr int kFirstGreen = 3;              // the turtle's colour of Lparser's color 2
constexpr double kThicknessPercent = 10.0;  // of a file that gives none

// 0 to 4 are documented; the others are Espalier's choice
constexpr std::array<files::PaletteColour, 16> kPalette{
    files::PaletteColour{128, 128, 128}, files::PaletteColour{220, 40, 40},   files::PaletteColour{50, 160, 50},
    files::PaletteColour{50, 80, 210},   files::PaletteColour{250, 245, 130}, files::PaletteColour{160, 60, 180},
    files::PaletteColour{70, 190, 200},  files::PaletteColour{240, 150, 40},  files::PaletteColour{130, 90, 50},
    files::PaletteColour{20, 90, 40},    files::PaletteColour{240, 150, 180}, files::PaletteColour{130, 200, 90},
    files::PaletteColour{120, 170, 240}, files::PaletteColour{70, 70, 70},    files::PaletteColour{200, 180, 140},
    files::PaletteColour{240, 240, 240}};

/// The effect of a symbol of the turtle, as cpfg modules: without a number, and with the number x.
struct Drawing {
  char symbol;
  std::string_view plain;
  std::string_view withNumber;
};
constexpr std::array kDrawings = {
    Drawing{'<', "\\", "\\(x)"},
    Drawing{'>', "/", "/(x)"},
    Drawing{'|', "|", "|"},
    Drawing{'%', "/(180)", "/(180)"},
    Drawing{'$', "@v", "@v"},
    Drawing{'~', "+(ran(360)-180)&(ran(360)-180)/(ran(360)-180)", "+(ran(2*x)-x)&(ran(2*x)-x)/(ran(2*x)-x)"},
    Drawing{'t', "@B(0.2)", "@B(x)"},
    Drawing{'Z', "F(0.5)", "F(x)"},
    Drawing{'z', "f(0.5)", "f(x)"},
    Drawing{'"', "@Di(1.1)", "@Di(x)"},
    Drawing{'\'', "@Di(0.9)", "@Di(x)"},
    Drawing{';', "@A(1.1)", "@A(x)"},
    Drawing{':', "@A(0.9)", "@A(x)"},
    Drawing{'?', "@W(1.4)", "@W(x)"},
    Drawing{'!', "@W(0.7)", "@W(x)"},
    Drawing{'c', ";", ";(x+1)"},  // the turtle's colour 0 is the background
};

// a line without its remark
TextPiece codeOf(const TextPiece& line) {
  return line.to(line.text.find('#')).trimmed();
}

// the first word of a line in small letters, and the rest
std::pair<std::string, TextPiece> wordOf(const TextPiece& code) {
  const std::size_t end = std::min(code.text.find_first_of(" \t=:"), code.text.size());
  TextPiece value = code.from(end).trimmed();
  if (value.text.starts_with('=') || value.text.starts_with(':')) {
    value = value.from(1).trimmed();
  }
  return {lowered(code.text.substr(0, end)), value};
}

bool isWord(std::string_view word) {
  return std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

// the first number of a line, where a remark without `#` may follow
std::optional<double> firstNumber(std::string_view text) {
  return core::parseNumber(text.substr(0, text.find_first_not_of("+-.0123456789")));
}

class LparserReader {
 public:
  LparserReader(std::string_view text, DialectReport& report) : text_(text), report_(report) {}

  CpfgModel read() {
    const std::vector<TextPiece> lines = codeLines();
    const bool isNew = std::any_of(lines.begin(), lines.end(), [](const TextPiece& line) {
      const std::string word = wordOf(line).first;
      return word == "axiom" || word == "recursion";
    });
    isNew ? readWords(lines) : readInOrder(lines);
    finish();
    return std::move(model_);
  }

 private:
  // the lines up to the `@` that ends the old form
  [[nodiscard]] std::vector<TextPiece> codeLines() const {
    std::vector<TextPiece> lines;
    for (const TextPiece& line : linesOf(text_)) {
      const TextPiece code = codeOf(line);
      if (code.text == "@") {
        break;
      }
      if (!code.empty()) {
        lines.push_back(code);
      }
    }
    return lines;
  }

  void readWords(const std::vector<TextPiece>& lines) {
    for (const TextPiece& line : lines) {
      const auto [word, value] = wordOf(line);
      if (word == "rule") {
        readRule(value);
      } else if (word == "axiom") {
        readAxiom(value);
      } else if (isWord(word)) {
        readNumber(word, value, line);
      } else {
        report_.error(line.offset, word.size(), "unknown word '" + word.substr(0, 40) + "'",
                      core::suggestName(word, {kWords.begin(), kWords.end()}));
      }
    }
  }

  // recursion, angle, thickness, axiom, rules
  void readInOrder(const std::vector<TextPiece>& lines) {
    constexpr std::array<std::string_view, 3> kNumbers{"recursion", "angle", "thickness"};
    std::size_t next = 0;
    for (const TextPiece& line : lines) {
      if (next < kNumbers.size()) {
        readNumber(std::string(kNumbers[next]), line, line);
      } else if (next == kNumbers.size()) {
        readAxiom(line);
      } else {
        readRule(line);
      }
      ++next;
    }
    if (next <= kNumbers.size()) {
      report_.error(text_.size(), 1, "the file ends before the axiom",
                    "the lines of an .ls file are: recursion depth, angle, thickness, axiom, rules X=..., @");
    }
  }

  void readNumber(const std::string& word, const TextPiece& value, const TextPiece& line) {
    const std::optional<double> number = firstNumber(value.text);
    const bool isCount = word == "recursion";
    if (!number || (isCount && (*number < 0.0 || *number != std::floor(*number) || *number > kMostRecursion))) {
      report_.error(value.empty() ? line.offset : value.offset, value.empty() ? line.text.size() : value.text.size(),
                    "expected " + std::string(isCount ? "a whole number from 0 to 1000000" : "a number") +
                        " while reading " + word + ", found '" + std::string(value.text.substr(0, 40)) + "'",
                    "the lines of an .ls file are: recursion depth, angle, thickness, axiom, rules X=..., @");
      return;
    }
    if (isCount) {
      model_.derivationLength = static_cast<std::uint64_t>(*number);
    } else if (word == "angle") {
      model_.angleDegrees = *number;
    } else if (word == "thickness") {
      thickness_ = *number;
    } else {
      model_.lost.emplace_back("'" + word + "', which sets only the look of Lparser's own pictures");
    }
  }

  void readAxiom(const TextPiece& value) {
    checkBrackets(text_, value.offset, value.offset + value.text.size(), "the axiom", report_);
    model_.axiom = modules(value);
    if (model_.axiom.empty()) {
      report_.error(value.offset, 1, "the axiom is empty", "write the first string behind it");
      model_.axiom.make("F", value.offset);
    }
    hasAxiom_ = true;
  }

  void readRule(const TextPiece& rule) {
    const std::size_t equals = rule.text.find('=', 1);
    const TextPiece left = equals == std::string_view::npos ? rule : rule.to(equals).trimmed();
    if (equals == std::string_view::npos || left.text.size() != 1) {
      report_.error(rule.offset, rule.text.size(),
                    "expected a rule such as 'A=F[+A]', found '" + std::string(rule.text.substr(0, 40)) + "'",
                    "a rule is one character, '=' and its string");
      return;
    }
    const std::optional<char> symbol = symbolOf(left.text.front(), left.offset);
    if (!symbol || *symbol == '[' || *symbol == ']') {
      report_.error(left.offset, 1, "the character '" + std::string(left.text) + "' cannot be rewritten",
                    "give the rule a letter");
      return;
    }
    if (!rewritten_.insert(*symbol).second) {
      report_.error(left.offset, 1, "there is a rule for '" + std::string(left.text) + "' already",
                    "each symbol has one rule in a deterministic L-system");
      return;
    }
    const TextPiece value = rule.from(equals + 1).trimmed();
    checkBrackets(text_, value.offset, value.offset + value.text.size(), "the rule of " + std::string(left.text),
                  report_);
    rules_.push_back({*symbol, modules(value), left.offset});
  }

  /// The cpfg symbol of a character; `< > :` and others that cpfg cannot use get a letter that no file uses.
  std::optional<char> symbolOf(char c, std::size_t offset) {
    const bool isUsable =
        c > ' ' && c < 127 && std::string_view("<>:*()%?$@,#/\\=_\"~").find(c) == std::string_view::npos;
    if (isUsable) {
      return c;
    }
    const auto known = letters_.find(c);
    if (known != letters_.end()) {
      return known->second;
    }
    // no symbol of the file or of the turtles
    for (const char letter : std::string_view("abdehijklmnopqruvwxy0123456789")) {
      const bool isTaken =
          std::any_of(letters_.begin(), letters_.end(), [&](const auto& entry) { return entry.second == letter; });
      if (!isTaken && !isSymbolOfFile(letter)) {
        letters_[c] = letter;
        return letter;
      }
    }
    report_.error(offset, 1, std::string("the character '") + c + "' cannot be a symbol here", "use a letter instead");
    return std::nullopt;
  }

  // whether a letter stands in a string of the file; the words of the new form are no strings
  [[nodiscard]] bool isSymbolOfFile(char letter) const {
    for (const TextPiece& line : codeLines()) {
      const auto [word, value] = wordOf(line);
      const bool isString = !isWord(word) || word == "axiom" || word == "rule";
      if (isString && (isWord(word) ? value : line).text.find(letter) != std::string_view::npos) {
        return true;
      }
    }
    return false;
  }

  MappedText modules(const TextPiece& piece) {
    MappedText result;
    const std::string_view text = piece.text;
    for (std::size_t at = 0; at < text.size();) {
      const char c = text[at];
      const std::size_t offset = piece.offset + at;
      const std::size_t length = std::min(characterLength(c), text.size() - at);
      at += length;
      if (c == ' ' || c == '\t') {
        continue;
      }
      const std::optional<char> symbol = length == 1 ? symbolOf(c, offset) : std::nullopt;
      if (!symbol) {
        if (length > 1) {
          report_.error(offset, length,
                        "the character '" + std::string(text.substr(at - length, length)) + "' cannot be a symbol here",
                        "use a letter instead");
        }
        continue;
      }
      if (c == *symbol) {
        result.copy(text.substr(at - 1, 1), offset);
      } else {
        result.make(std::string(1, *symbol), offset);
      }
      if (at < text.size() && text[at] == '(') {
        at = readParameter(text, at, offset, *symbol, result);
      } else {
        plain_.insert(*symbol);
      }
    }
    return result;
  }

  // `(x)` behind a symbol; returns the place behind it
  std::size_t readParameter(std::string_view text, std::size_t at, std::size_t offset, char symbol,
                            MappedText& result) {
    const std::size_t end = text.find(')', at);
    const std::optional<double> number =
        end == std::string_view::npos
            ? std::nullopt
            : core::parseNumber(TextPiece{text.substr(at + 1, end - at - 1), 0}.trimmed().text);
    if (!number) {
      report_.error(offset, 1, "expected one number in parentheses, as in '+(90)'",
                    "a symbol has at most one number, and no expression");
      return end == std::string_view::npos ? text.size() : end + 1;
    }
    result.make("(" + cpfgNumber(*number) + ")", offset);
    withNumber_.insert(symbol);
    return end + 1;
  }

  void finish() {
    if (!hasAxiom_) {
      report_.error(0, 1, "the model has no axiom", "write the first string behind the word axiom");
    }
    for (const Rule& rule : rules_) {
      MappedText production(std::string(1, rule.symbol) + " --> ", rule.offset);
      production.add(rule.successor.empty() ? MappedText("*", rule.offset) : rule.successor);
      // the rule holds for the symbol with a number, too
      if (withNumber_.contains(rule.symbol)) {
        MappedText other(std::string(1, rule.symbol) + "(x) --> ", rule.offset);
        other.add(rule.successor.empty() ? MappedText("*", rule.offset) : rule.successor);
        model_.productions.push_back(std::move(other));
      }
      model_.productions.push_back(std::move(production));
    }
    addDrawing();
    model_.viewCommands.push_back("initial line width: " + cpfgNumber(thickness_ / 100.0));
    model_.viewCommands.emplace_back("line style: cylinder");
    model_.colour = kFirstGreen;
    model_.palette[0] = {255, 255, 255};
    for (int i = 1; i < 256; ++i) {
      model_.palette[i] = kPalette[static_cast<std::size_t>(i - 1) % kPalette.size()];
    }
    model_.lost.emplace_back("the colors of the numbers behind c");
  }

  void addDrawing() {
    const auto nameOf = [&](char c) {
      const auto letter = letters_.find(c);
      return letter == letters_.end() ? c : letter->second;
    };
    std::set<char> drawn;
    for (const Drawing& drawing : kDrawings) {
      const char symbol = nameOf(drawing.symbol);
      drawn.insert(symbol);
      const auto add = [&](const std::string& predecessor, std::string_view modules) {
        // cpfg has no such commands
        const bool isOwn = modules.starts_with("@A") || modules.starts_with("@W") || modules.starts_with("@B");
        needsOwn_ = needsOwn_ || isOwn;
        model_.drawing.emplace_back(predecessor + " --> " + std::string(modules), 0);
      };
      if (plain_.contains(symbol)) {
        add(std::string(1, symbol), drawing.plain);
      }
      if (withNumber_.contains(symbol)) {
        add(std::string(1, symbol) + "(x)", drawing.withNumber);
      }
    }
    if (needsOwn_) {
      model_.needs.emplace_back("turtle commands that multiply angles and widths or bend down");
    }
    // a name of a rule that cpfg's turtle would obey
    std::set<char> silent;
    std::set_difference(plain_.begin(), plain_.end(), drawn.begin(), drawn.end(), std::inserter(silent, silent.end()));
    silence(silent, "+-&^Ffg.[]{}", model_);
    if (withNumber_.contains('G')) {
      model_.drawing.emplace_back("G(x) --> *", 0);
    }
  }

  struct Rule {
    char symbol = '\0';
    MappedText successor;
    std::size_t offset = 0;
  };

  std::string_view text_;
  DialectReport& report_;
  CpfgModel model_;
  std::vector<Rule> rules_;
  double thickness_ = kThicknessPercent;
  bool hasAxiom_ = false;
  bool needsOwn_ = false;
  std::set<char> rewritten_;
  std::set<char> plain_;          // cpfg symbols without a number
  std::set<char> withNumber_;     // with a number
  std::map<char, char> letters_;  // for the characters that cpfg cannot use
};

// `X=...`: one character and '='
bool isRuleLine(std::string_view code) {
  return code.size() > 1 && code[1] == '=' && code[0] > ' ' && code[0] < 127;
}

}  // namespace

bool recognisesLparser(std::string_view text) {
  std::set<std::string> words;
  std::vector<std::string_view> codes;
  bool hasEnd = false;
  std::size_t ruleCount = 0;
  bool hasNamedRule = false;
  for (const TextPiece& line : linesOf(text)) {
    const TextPiece code = codeOf(line);
    if (code.empty()) {
      continue;
    }
    const auto [word, value] = wordOf(code);
    words.insert(word);
    codes.push_back(code.text);
    const bool isSpaced = value.text.size() > 1 && (value.text.find('=') == 1 || value.text.find(" =") == 1);
    hasNamedRule = hasNamedRule || (word == "rule" && isSpaced && value.text.find("->") == std::string_view::npos);
    hasEnd = hasEnd || code.text == "@";
    ruleCount += isRuleLine(code.text) || TextPiece{code.text, 0}.from(1).trimmed().text.starts_with('=') ? 1 : 0;
  }
  // the new form, whose words no other notation has together
  const int known = (words.contains("axiom") ? 1 : 0) + (words.contains("thickness") ? 1 : 0) + (hasNamedRule ? 1 : 0);
  if (words.contains("recursion") && known > 1) {
    return true;
  }
  // the old form: three numbers, a string, and rules
  const auto isNumber = [&](std::size_t i) { return i < codes.size() && firstNumber(codes[i]).has_value(); };
  return isNumber(0) && isNumber(1) && isNumber(2) && codes.size() > 3 && !firstNumber(codes[3]) &&
         (hasEnd || ruleCount > 0);
}

CpfgModel translateLparser(std::string_view text, const std::string& /*entry*/, DialectReport& report) {
  return LparserReader(text, report).read();
}

}  // namespace espalier::language

#include "engine/language/dialects/fractint.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "engine/core/number_text.h"
#include "engine/language/dialects/text_lines.h"

namespace espalier::language {
namespace {

constexpr std::uint64_t kOrder = 2;  // derivation length; it is not in the file, Fractint asks the user
constexpr int kLeastAngle = 3;

// the 16 colours of a VGA by Fractint's colour numbers; 0 is the background
constexpr files::PaletteColour kColours[16] = {{0, 0, 0},     {0, 0, 168},    {0, 168, 0},    {0, 168, 168},
                                               {168, 0, 0},   {168, 0, 168},  {168, 84, 0},   {168, 168, 168},
                                               {84, 84, 84},  {84, 84, 252},  {84, 252, 84},  {84, 252, 252},
                                               {252, 84, 84}, {252, 84, 252}, {252, 252, 84}, {252, 252, 252}};
// of 63, the largest value of a component
constexpr std::array<int, 16> kGreys{0, 5, 8, 11, 14, 17, 20, 24, 28, 32, 36, 40, 45, 50, 56, 63};
constexpr std::array<std::array<int, 5>, 9> kLevels{{{0, 16, 31, 47, 63},
                                                     {31, 39, 47, 55, 63},
                                                     {45, 49, 54, 58, 63},
                                                     {0, 7, 14, 21, 28},
                                                     {14, 17, 21, 24, 28},
                                                     {20, 22, 24, 26, 28},
                                                     {0, 4, 8, 12, 16},
                                                     {8, 10, 12, 14, 16},
                                                     {11, 12, 13, 15, 16}}};
// red, green and blue of each hue as levels a to e
constexpr std::string_view kHues = "aaebaecaedaeeaeeadeaceabeaaebaecaedaeeadeaceabeaaeaaebaecaedaeeadeaceabe";

/// The default palette of a screen with 256 colours (the VGA's): the sixteen, greys, nine runs of 24 hues, black.
files::PaletteColour screenColour(int index) {
  const auto full = [](int sixth) { return static_cast<std::uint8_t>(sixth * 4); };
  if (index < 16) {
    return kColours[index];
  }
  if (index < 32) {
    const std::uint8_t grey = full(kGreys[static_cast<std::size_t>(index - 16)]);
    return {grey, grey, grey};
  }
  if (index >= 248) {
    return {0, 0, 0};
  }
  const auto run = static_cast<std::size_t>((index - 32) / 24);
  const auto hue = static_cast<std::size_t>((index - 32) % 24);
  const auto level = [&](std::size_t component) {
    return full(kLevels[run][static_cast<std::size_t>(kHues[hue * 3 + component] - 'a')]);
  };
  return {level(0), level(1), level(2)};
}
constexpr int kFirstColour = 15;

std::string_view withoutComment(std::string_view line) {
  return line.substr(0, line.find(';'));
}

bool hasArrow(std::string_view text) {
  return text.find("->") != std::string_view::npos || text.find("→") != std::string_view::npos;
}

/// The text between the braces of an entry.
struct EntryText {
  DialectEntry entry;
  TextPiece body;
  bool isClosed = false;
};

// comments may hold braces, so the search ignores them
std::vector<EntryText> entryTexts(std::string_view text) {
  std::vector<EntryText> found;
  bool isOpen = false;
  TextPiece before;  // a word alone on the line before
  for (const TextPiece& line : linesOf(text)) {
    const std::string_view code = withoutComment(line.text);
    std::size_t at = 0;
    if (!isOpen) {
      const std::size_t brace = code.find('{');
      // `F -> F{+F.` is a production of another notation with a polygon
      if (brace == std::string_view::npos || hasArrow(code.substr(0, brace))) {
        const TextPiece word = TextPiece{code, line.offset}.trimmed();
        before = word.text.find_first_of(" \t}") == std::string_view::npos ? word : TextPiece{};
        continue;
      }
      const TextPiece front = line.to(brace).trimmed();
      const TextPiece name = front.empty() ? before : front;
      before = {};
      // a remark in parentheses may follow the name
      const std::string_view word = name.text.substr(0, name.text.find_first_of(" \t("));
      at = brace + 1;
      found.push_back({{std::string(word), name.offset}, {text.substr(line.offset + at, 0), line.offset + at}, false});
      isOpen = true;
    }
    const std::size_t close = code.find('}', at);
    EntryText& entry = found.back();
    const std::size_t end = close == std::string_view::npos ? line.text.size() : close;
    entry.body.text = text.substr(entry.body.offset, line.offset + end - entry.body.offset);
    if (close != std::string_view::npos) {
      entry.isClosed = true;
      isOpen = false;
    }
  }
  // blocks of remarks are not entries
  std::erase_if(
      found, [](const EntryText& entry) { return entry.entry.name.empty() || lowered(entry.entry.name) == "comment"; });
  // the second of equal names is NAME-2
  std::map<std::string, std::size_t> counts;
  for (EntryText& entry : found) {
    const std::size_t count = ++counts[lowered(entry.entry.name)];
    entry.entry.name += count > 1 ? "-" + std::to_string(count) : "";
  }
  return found;
}

class FractintReader {
 public:
  FractintReader(std::string_view text, DialectReport& report) : text_(text), report_(report) {}

  CpfgModel read(const EntryText& entry) {
    for (const TextPiece& line : linesOf(entry.body.text, entry.body.offset)) {
      const TextPiece statement = TextPiece{withoutComment(line.text), line.offset}.trimmed();
      if (!statement.empty()) {
        readStatement(statement);
      }
    }
    if (!entry.isClosed) {
      report_.error(entry.entry.offset, entry.entry.name.size(), "the entry '" + entry.entry.name + "' has no '}'",
                    "an entry is NAME { Angle N, Axiom STRING and rules X=STRING, one a line }");
    }
    if (!angle_) {
      report_.error(entry.entry.offset, entry.entry.name.size(), "the entry '" + entry.entry.name + "' has no Angle",
                    "'Angle 6' makes + and - turn by 360/6 degrees");
    }
    if (model_.axiom.empty()) {
      report_.error(entry.entry.offset, entry.entry.name.size(), "the entry '" + entry.entry.name + "' has no Axiom",
                    "write the first string behind the word Axiom");
    }
    finish(entry.entry.offset);
    return std::move(model_);
  }

 private:
  void readStatement(const TextPiece& statement) {
    const std::size_t wordEnd = std::min(statement.text.find_first_of(" \t="), statement.text.size());
    const std::string word = lowered(statement.text.substr(0, wordEnd));
    TextPiece value = statement.from(wordEnd).trimmed();
    // `angle=6` and `axiom=F` are read as well
    if (word == "angle" || word == "axiom") {
      value = value.text.starts_with('=') ? value.from(1).trimmed() : value;
      return word == "angle" ? readAngle(value, statement) : readAxiom(value, statement);
    }
    const std::size_t equals = statement.text.find('=');
    if (equals == std::string_view::npos) {
      report_.error(
          statement.offset, statement.text.size(),
          "expected Angle, Axiom or a rule X=..., found '" + std::string(statement.text.substr(0, 40)) + "'",
          std::string(core::nearestName(word, {"angle", "axiom"}).empty()
                          ? "a rule is one character, '=' and its string"
                          : "did you mean '" + std::string(core::nearestName(word, {"angle", "axiom"})) + "'?"));
      return;
    }
    readRule(statement.to(equals).trimmed(), statement.from(equals + 1).trimmed());
  }

  void readAngle(const TextPiece& value, const TextPiece& statement) {
    const std::optional<double> number = core::parseNumber(value.text);
    if (!number || *number != std::floor(*number) || *number < kLeastAngle || *number > 1e6) {
      report_.error(value.empty() ? statement.offset : value.offset, value.text.size(),
                    "expected a whole number from 3 to 1000000 while reading Angle, found '" +
                        std::string(value.text.substr(0, 40)) + "'",
                    "+ and - turn by 360 degrees divided by it");
      angle_ = kLeastAngle;
      return;
    }
    angle_ = static_cast<int>(*number);
  }

  void readAxiom(const TextPiece& value, const TextPiece& statement) {
    checkBrackets(text_, value.offset, value.offset + value.text.size(), "the Axiom", report_);
    model_.axiom = modules(value);
    if (model_.axiom.empty()) {
      report_.error(statement.offset, statement.text.size(), "the Axiom is empty", "write the first string behind it");
      model_.axiom.make("F", statement.offset);
    }
  }

  void readRule(const TextPiece& predecessor, const TextPiece& successor) {
    if (predecessor.empty() || predecessor.text.size() != characterLength(predecessor.text.front())) {
      report_.error(predecessor.offset, predecessor.text.size(),
                    "expected one character before '=', found '" + std::string(predecessor.text.substr(0, 40)) + "'",
                    "a rule is one character, '=' and its string");
      return;
    }
    if (std::string_view("\\/@<>[]").find(predecessor.text.front()) != std::string_view::npos) {
      report_.error(predecessor.offset, 1, "the character '" + std::string(predecessor.text) + "' cannot be rewritten",
                    "give the rule a letter");
      return;
    }
    const std::optional<char> named = symbolOf(predecessor.text, predecessor.offset);
    if (!named) {
      return;
    }
    const char symbol = *named;
    checkBrackets(text_, successor.offset, successor.offset + successor.text.size(),
                  std::string("the rule of ") + symbol, report_);
    used_.insert(symbol);
    // several rules of one character are joined
    auto [rule, isNew] = rules_.try_emplace(symbol);
    if (isNew) {
      order_.push_back(symbol);
      rule->second.offset = predecessor.offset;
    }
    rule->second.successor.add(modules(successor));
  }

  static char upper(char c) { return static_cast<char>(std::toupper(static_cast<unsigned char>(c))); }
  // of the characters that cpfg can use as a symbol without a parameter
  static bool isSymbol(char c) {
    return c > ' ' && c < 127 && std::string_view("<>:*%?$();,\"'{}#~&^._").find(c) == std::string_view::npos;
  }

  /// The symbol that stands for a character: itself in capitals, or a small letter for a character that cpfg cannot
  /// use. Nothing, with an error, when the small letters do not suffice.
  std::optional<char> symbolOf(std::string_view character, std::size_t offset) {
    const char symbol = upper(character.front());
    if (isSymbol(symbol)) {
      return symbol;
    }
    constexpr std::string_view kFree = "abcdehijklmnopqrtuvwxyz";  // the turtle obeys none of them
    const auto known = letters_.find(std::string(character));
    if (known != letters_.end()) {
      return known->second;
    }
    if (letters_.size() == kFree.size()) {
      report_.error(offset, character.size(), "the character '" + std::string(character) + "' cannot be a symbol here",
                    "the entry has too many different signs: use a letter instead");
      return std::nullopt;
    }
    return letters_.emplace(character, kFree[letters_.size()]).first->second;
  }

  // a number with I (inverse) and Q (square root) before it; `at` moves behind it
  std::optional<double> readNumber(std::string_view text, std::size_t& at) {
    bool isInverse = false;
    bool isRoot = false;
    std::size_t position = at;
    for (; position < text.size() && (upper(text[position]) == 'I' || upper(text[position]) == 'Q'); ++position) {
      (upper(text[position]) == 'I' ? isInverse : isRoot) = true;
    }
    std::size_t end = position;
    while (end < text.size() && (std::isdigit(static_cast<unsigned char>(text[end])) != 0 || text[end] == '.')) {
      ++end;
    }
    const std::optional<double> number = core::parseNumber(text.substr(position, end - position));
    if (!number) {
      return std::nullopt;
    }
    at = end;
    const double root = isRoot ? std::sqrt(*number) : *number;
    return isInverse ? 1.0 / root : root;
  }

  MappedText modules(const TextPiece& piece) {
    MappedText result;
    const std::string_view text = piece.text;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t begin = at;
      const std::size_t offset = piece.offset + begin;
      const char symbol = upper(text[at]);
      if (symbol == ' ' || symbol == '\t') {
        ++at;
        continue;
      }
      at += 1;
      const std::string_view before = result.text();
      const bool isColour =
          symbol == 'C' && at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])) != 0;
      if (symbol == '@' || symbol == '\\' || symbol == '/' || isColour) {
        const double number = readNumber(text, at).value_or(symbol == '@' ? 1.0 : 0.0);
        if (!std::isfinite(number)) {
          report_.error(offset, 1, std::string("the number behind '") + symbol + "' is not finite",
                        "I is the inverse of the number behind it: write one that is not 0");
          continue;
        }
        // two slashes in a row would begin a comment, and so would a slash and a star
        result.make(std::string(before.ends_with('/') ? " " : "") + symbol + "(" + cpfgNumber(number) + ")", offset);
        used_.insert(symbol);
        parametric_.insert(symbol);
      } else if (symbol == '<' || symbol == '>') {
        std::size_t end = at;
        while (end < text.size() && std::isdigit(static_cast<unsigned char>(text[end])) != 0) {
          ++end;
        }
        const std::string_view digits = text.substr(at, end - at);
        const double count = std::fmod(core::parseNumber(digits).value_or(1.0), 256.0);
        at = end;
        result.make(symbol == '<' ? ";" : ",", offset);
        if (!digits.empty()) {
          addsNumbers_ = true;
          result.make("(" + cpfgNumber(count) + ")", offset);
        }
        usesColour_ = true;
      } else {
        const std::size_t length = std::min(characterLength(text[begin]), text.size() - begin);
        at = begin + length;
        const std::optional<char> named = symbolOf(text.substr(begin, length), offset);
        if (!named) {
          continue;
        }
        if (text[begin] == *named) {
          result.copy(text.substr(begin, 1), offset);
        } else {
          result.make(std::string(1, *named), offset);
        }
        used_.insert(*named);
      }
    }
    return result;
  }

  void finish(std::size_t offset) {
    for (const char symbol : order_) {
      const Rule& rule = rules_.at(symbol);
      MappedText production(std::string(1, symbol) + " --> ", rule.offset);
      production.add(rule.successor.empty() ? MappedText("*", rule.offset) : rule.successor);
      model_.productions.push_back(std::move(production));
    }
    const int parts = angle_.value_or(kLeastAngle);
    model_.derivationLength = kOrder;
    model_.angleDegrees = 360.0 / parts;
    model_.headingDegrees = 0.0;
    const auto draw = [&](char symbol, const std::string& modules) {
      if (used_.count(symbol) > 0) {
        const std::string formal =
            parametric_.count(symbol) > 0 ? std::string(1, symbol) + "(x)" : std::string(1, symbol);
        model_.drawing.emplace_back(formal + " --> " + modules, offset);
      }
    };
    draw('G', "f");
    // + - | turn the heading of F and G, \ and / turn the heading of D and M
    const auto uses = [&](std::string_view symbols) {
      return std::any_of(symbols.begin(), symbols.end(), [&](char symbol) { return used_.count(symbol) > 0; });
    };
    const bool movesByParts = uses("FG");
    const bool movesByDegrees = uses("DM");
    const bool ignoresDegrees = movesByParts && !movesByDegrees;
    const bool ignoresParts = movesByDegrees && !movesByParts;
    // with both, the heading of D and M is the turtle's other orientation
    const bool hasTwo = movesByParts && movesByDegrees && (uses("+-|") || uses("\\/"));
    const auto other = [&](const std::string& modules) { return hasTwo ? "@X" + modules + "@X" : modules; };
    draw('D', other("F"));
    draw('M', other("f"));
    draw('\\', ignoresDegrees ? "*" : other("+(x)"));
    draw('/', ignoresDegrees ? "*" : other("-(x)"));
    if (ignoresParts) {
      draw('+', "*");
      draw('-', "*");
    }
    draw('@', "@Di(x)");
    // half a turn, or the largest smaller turn of whole parts, clockwise even for a turtle on its back
    const std::string part = cpfgNumber(parts / 2 * 360.0 / parts);
    const bool isClockwise = parts % 2 != 0 && used_.count('!') > 0;
    if (isClockwise && used_.count('|') > 0 && !ignoresParts) {
      model_.ownDrawing.emplace_back("| --> @Z(-" + part + ")", offset);
      model_.needs.emplace_back("turn in the plane of the picture, which | makes whatever ! has exchanged");
    } else {
      draw('|', ignoresParts ? "*" : (parts % 2 == 0 ? "+(" : "-(") + part + ")");
    }
    // the turtle on its back has left and right exchanged
    draw('!', hasTwo ? "/(180)@X/(180)@X" : "/(180)");
    if (parametric_.count('C') > 0) {
      draw('C', ";(x)");
    }
    if (usesColour_ || parametric_.count('C') > 0) {
      model_.colour = kFirstColour;
      model_.lost.emplace_back("the 256 colours of the screen that the color numbers mean, and the first of them, 15");
      for (int i = 0; i < 256; ++i) {
        model_.palette[i] = screenColour(i);
      }
    }
    if (usesColour_) {
      for (const auto& [symbol, sign] : {std::pair{';', ""}, std::pair{',', "-"}}) {
        model_.ownDrawing.emplace_back(std::string(1, symbol) + " --> @C(" + sign + "1)", offset);
        model_.ownDrawing.emplace_back(std::string(1, symbol) + "(x) --> @C(" + sign + "x)", offset);
      }
      model_.lost.emplace_back("that < and > skip color 0");
      if (addsNumbers_) {
        model_.needs.emplace_back("colour increment by a number, as in <3");
      }
    }
    if (hasTwo) {
      model_.needs.emplace_back("second heading, which D and M have beside that of F and G");
    }
  }

  struct Rule {
    MappedText successor;
    std::size_t offset = 0;
  };

  std::string_view text_;
  DialectReport& report_;
  CpfgModel model_;
  std::optional<int> angle_;
  std::map<char, Rule> rules_;
  std::vector<char> order_;  // of the rules' first lines
  std::set<char> used_;
  std::set<char> parametric_;            // with a number
  std::map<std::string, char> letters_;  // for the characters that cpfg cannot use as symbols
  bool usesColour_ = false;
  bool addsNumbers_ = false;  // to the color
};

}  // namespace

bool recognisesFractint(std::string_view text) {
  for (const EntryText& entry : entryTexts(text)) {
    for (const TextPiece& line : linesOf(entry.body.text)) {
      const std::string code = lowered(TextPiece{withoutComment(line.text), 0}.trimmed().text);
      // `axiom: F` is another notation
      if ((code.starts_with("angle") || code.starts_with("axiom")) && !code.substr(5).starts_with(':')) {
        return true;
      }
    }
  }
  return false;
}

std::vector<DialectEntry> fractintEntries(std::string_view text) {
  std::vector<DialectEntry> entries;
  for (EntryText& found : entryTexts(text)) {
    entries.push_back(std::move(found.entry));
  }
  return entries;
}

CpfgModel translateFractint(std::string_view text, const std::string& entry, DialectReport& report) {
  for (const EntryText& found : entryTexts(text)) {
    if (found.entry.name == entry) {
      return FractintReader(text, report).read(found);
    }
  }
  report.error(0, 1, "the file has no entry",
               "an entry is NAME { Angle N, Axiom STRING and rules X=STRING, one a line }");
  return {};
}

}  // namespace espalier::language

#include "engine/language/dialects/textbook/textbook_signs.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>
#include <vector>

#include "engine/core/work_meter.h"
#include "engine/language/dialects/text_lines.h"
#include "engine/language/dialects/textbook/textbook_modules.h"
#include "engine/language/dialects/textbook/textbook_statements.h"
#include "engine/language/dialects/textbook/textbook_words.h"

namespace espalier::language {
namespace {

using Replacement = std::pair<std::string_view, char>;
constexpr std::array kReplacements = {
    Replacement{"−", '-'},  Replacement{"–", '-'},      Replacement{"—", '-'},       Replacement{"‐", '-'},
    Replacement{"‑", '-'},  Replacement{"’", '\''},     Replacement{"‘", '\''},      Replacement{"′", '\''},
    Replacement{"´", '\''}, Replacement{"“", '"'},      Replacement{"”", '"'},       Replacement{"„", '"'},
    Replacement{"∣", '|'},  Replacement{"│", '|'},      Replacement{"＋", '+'},      Replacement{"∗", '*'},
    Replacement{"∕", '/'},  Replacement{"⁄", '/'},      Replacement{"∖", '\\'},      Replacement{"＝", '='},
    Replacement{"：", ':'}, Replacement{"（", '('},     Replacement{"）", ')'},      Replacement{"，", ','},
    Replacement{"ˆ", '^'},  Replacement{"\u00AD", ' '}, Replacement{"\u2028", '\n'},
};

void blankOut(std::string& text, std::size_t begin, std::size_t end) {
  for (std::size_t at = begin; at < end; ++at) {
    text[at] = text[at] == '\n' || text[at] == '\r' ? text[at] : ' ';
  }
}

// a comment may have several lines; one that is never closed ends with its line
void blankComments(std::string& text) {
  for (std::size_t at = text.find("/*"); at != std::string::npos; at = text.find("/*", at)) {
    core::pollWork();
    const std::size_t close = text.find("*/", at + 2);
    const std::size_t end = close == std::string::npos ? std::min(text.find('\n', at), text.size()) : close + 2;
    blankOut(text, at, end);
  }
}

void replaceSigns(std::string& text) {
  for (std::size_t at = 0; at < text.size(); ++at) {
    core::pollWork();
    if (static_cast<unsigned char>(text[at]) < 0x80) {
      continue;
    }
    for (const auto& [sign, character] : kReplacements) {
      if (std::string_view(text).substr(at).starts_with(sign)) {
        text[at] = character;
        const std::size_t end = at + sign.size();
        blankOut(text, at + 1, end);
        // parameters stand directly behind their module
        if (text.compare(end, 1, "(") == 0) {
          text[at + 1] = '(';
          text[end] = ' ';
        }
        break;
      }
    }
  }
  // the dashes of an arrow, which may be apart now
  for (std::size_t at = text.find("-  >"); at != std::string::npos; at = text.find("-  >", at)) {
    text.replace(at, 4, "  ->");
    for (std::size_t before = at; before >= 3 && text.compare(before - 3, 3, "-  ") == 0; before -= 3) {
      text[before - 3] = ' ';
    }
  }
}

struct LatexCommand {
  std::string_view name;
  std::string_view sign;
};
constexpr std::array kLatexArrows = {LatexCommand{"\\rightarrow", "→"}, LatexCommand{"\\longrightarrow", "→"},
                                     LatexCommand{"\\Rightarrow", "→"}, LatexCommand{"\\to", "→"}};
constexpr std::array kLatexSigns = {LatexCommand{"\\omega", "ω"}, LatexCommand{"\\delta", "δ"},
                                    LatexCommand{"\\leq", "≤"},   LatexCommand{"\\geq", "≥"},
                                    LatexCommand{"\\neq", "≠"},   LatexCommand{"\\times", "×"}};

// the place of a command, behind whose name no letter stands; npos: nowhere
std::size_t findLatex(std::string_view line, std::string_view name, std::size_t from = 0) {
  std::size_t at = line.find(name, from);
  while (at != std::string_view::npos && at + name.size() < line.size() &&
         std::isalpha(static_cast<unsigned char>(line[at + name.size()])) != 0) {
    at = line.find(name, at + 1);
  }
  return at;
}

// whether a line has an arrow of LaTeX, and no other
bool hasLatexArrow(std::string_view line) {
  return !arrowOf(line) && std::any_of(kLatexArrows.begin(), kLatexArrows.end(), [line](const LatexCommand& command) {
    return findLatex(line, command.name) != std::string_view::npos;
  });
}

void replaceLatex(std::string& text, const TextPiece& line, const LatexCommand& command) {
  for (std::size_t at = findLatex(line.text, command.name); at != std::string_view::npos;
       at = findLatex(line.text, command.name, at + 1)) {
    const std::size_t begin = line.offset + at;
    blankOut(text, begin, begin + command.name.size());
    text.replace(begin, command.sign.size(), command.sign);
  }
}

// `\omega: F`, `\delta = 90` without dollars
void readLatexSettings(std::string& text) {
  for (const TextPiece& line : linesOf(text)) {
    for (const LatexCommand& command : kLatexSigns) {
      const TextPiece code = line.trimmed();
      const TextPiece rest = code.from(std::min(command.name.size(), code.text.size())).trimmed();
      if (code.text.starts_with(command.name) && findLatex(code.text, command.name) == 0 &&
          rest.text.find_first_of(":=&") < 2) {
        replaceLatex(text, code, command);
      }
    }
  }
}

// `p1: $F \rightarrow FF$`; in a text with such lines, what stands between dollars, too
void readLatex(std::string& text) {
  const std::vector<TextPiece> lines = linesOf(text);
  const auto isRead = [](const TextPiece& line) {
    return line.text.find("\\begin") == std::string_view::npos && hasLatexArrow(line.text);
  };
  if (std::none_of(lines.begin(), lines.end(), isRead)) {
    return;
  }
  for (const TextPiece& line : lines) {
    if (!isRead(line) && (arrowOf(line.text) || std::count(line.text.begin(), line.text.end(), '$') < 2)) {
      continue;
    }
    for (const LatexCommand& command : kLatexArrows) {
      replaceLatex(text, line, command);
    }
    for (const LatexCommand& command : kLatexSigns) {
      replaceLatex(text, line, command);
    }
    for (std::size_t at = line.offset; at < line.offset + line.text.size(); ++at) {
      const bool isMarked = text[at] == '\\' && std::string_view("{}#").find(text[at + 1]) != std::string_view::npos;
      text[at] = text[at] == '$' || isMarked ? ' ' : text[at];
    }
  }
}

// `P = {` with its productions on lines of their own
void blankSetBraces(std::string& text) {
  for (const TextPiece& line : linesOf(text)) {
    const auto set = settingOf(line.trimmed());
    if (!set || set->setting != Setting::Productions || !set->value.text.starts_with('{')) {
      continue;
    }
    int depth = 0;
    std::size_t at = set->value.offset;
    do {
      core::pollWork();
      depth += text[at] == '{' ? 1 : text[at] == '}' ? -1 : 0;
      ++at;
    } while (depth > 0 && at < text.size());
    if (depth > 0) {
      return;
    }
    if (at > line.offset + line.text.size()) {
      text[set->value.offset] = ' ';
      text[at - 1] = ' ';
    }
  }
}

// braces around the whole text, perhaps with a name: `{ axiom: F … }`, `LSystem { … }`
void blankOuterBraces(std::string& text) {
  const std::size_t open = text.find('{');
  const std::size_t close = text.find_last_not_of(" \t\r\n;");
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  const TextPiece name = TextPiece{std::string_view(text).substr(0, open), 0}.from(begin).trimmed();
  const bool isName = std::all_of(name.text.begin(), name.text.end(),
                                  [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; });
  if (open == std::string::npos || text[close] != '}' || !isName) {
    return;
  }
  int depth = 0;
  for (std::size_t at = open; at < close; ++at) {
    depth += text[at] == '{' ? 1 : text[at] == '}' ? -1 : 0;
    if (depth == 0) {
      return;
    }
  }
  blankOut(text, 0, open + 1);
  text[close] = ' ';
}

bool isRuleValue(std::string_view value) {
  const bool hasModules = value.find_first_of("FGfgXYABLR[+-|") != std::string_view::npos ||
                          std::any_of(value.begin(), value.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
  return hasModules && !value.starts_with('{') && !textbookNumber(value);
}

// `F=F+F` and `rules: F=F+F, X=F` in a text without arrows
void markEqualsRules(std::string& text) {
  if (arrowOf(text)) {
    return;
  }
  bool hasAxiom = false;
  for (const TextPiece& line : linesOf(text)) {
    const auto setting = settingOf(line.trimmed());
    hasAxiom = hasAxiom || (setting && setting->setting == Setting::Axiom && setting->name.size() > 2);
  }
  if (!hasAxiom) {
    return;
  }
  std::vector<std::size_t> marks;
  bool isBelowHeading = false;
  for (const TextPiece& line : linesOf(text)) {
    const auto setting = settingOf(line.trimmed());
    const bool isList = setting && setting->setting == Setting::Productions;
    // `F: F+F` below `rules:`
    const TextPiece rule = line.trimmed();
    const std::size_t colon = rule.text.find(':');
    if (isBelowHeading && colon != std::string_view::npos && rule.to(colon).trimmed().text.size() == 1 &&
        isRuleValue(rule.from(colon + 1).trimmed().text)) {
      marks.push_back(rule.offset + colon);
      continue;
    }
    isBelowHeading = rule.empty() ? isBelowHeading : isList && setting->value.empty();
    const TextPiece code = isList ? setting->value : line.trimmed();
    if (setting && !isList && setting->name.size() > 1) {
      continue;
    }
    for (std::size_t at = code.text.find('='); at != std::string_view::npos; at = code.text.find('=', at + 1)) {
      const TextPiece front = code.to(at).trimmed();
      const bool isAlone = front.text.size() == 1 ||
                           (isList && front.text.size() > 1 &&
                            std::string_view(" ,;(").find(front.text[front.text.size() - 2]) != std::string_view::npos);
      if (isAlone && isRuleValue(code.from(at + 1).trimmed().text)) {
        marks.push_back(code.offset + at);
      }
      if (!isList) {
        break;
      }
    }
  }
  for (const std::size_t mark : marks) {
    text[mark] = kRuleMark.front();
  }
}

// `* axiom: F`, `2. F -> FF`, `- F -> FF`: lines of a list. A dash may be a symbol: it is a bullet when the axiom or
// all productions have one
void blankBullets(std::string& text) {
  std::vector<TextPiece> bullets;
  bool hasAxiom = false;
  bool areAll = true;  // productions have a bullet
  for (const TextPiece& line : linesOf(text)) {
    const TextPiece code = line.trimmed();
    std::size_t end = std::min(code.text.find_first_not_of("0123456789"), code.text.size());
    const bool isNumber = end > 0 && code.from(end).text.starts_with('.');
    end = isNumber ? end + 1 : code.text.starts_with("•") ? std::string_view("•").size() : 1;
    const bool isBullet =
        isNumber || code.text.starts_with("•") || code.text.starts_with('*') || code.text.starts_with('-');
    if (!isBullet || !code.from(end).text.starts_with(' ')) {
      areAll = areAll && !arrowOf(code.text);
      continue;
    }
    const TextPiece rest = code.from(end).trimmed();
    const auto arrow = arrowOf(rest.text);
    const auto setting = arrow ? std::nullopt : settingOf(rest);
    const bool isProduction = arrow && arrow->first > 0 && rest.text.front() != '<';
    hasAxiom = hasAxiom || (setting && setting->setting == Setting::Axiom);
    areAll = areAll && (isProduction || !arrow);
    if (isProduction || setting) {
      bullets.push_back(code.to(end));
    }
  }
  for (const TextPiece& bullet : bullets) {
    if (hasAxiom || areAll || !bullet.text.starts_with('-')) {
      blankOut(text, bullet.offset, bullet.offset + bullet.text.size());
    }
  }
}

// whether a quotation mark may open a string behind `before`, and close one in front of `behind`
bool opensString(std::string_view before) {
  const std::size_t last = before.find_last_not_of(" \t");
  return last == std::string_view::npos || std::string_view(":=>({,;").find(before[last]) != std::string_view::npos ||
         before.substr(0, last + 1).ends_with("→");
}

bool closesString(std::string_view behind) {
  const std::size_t first = behind.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) {
    return true;
  }
  const std::string_view rest = behind.substr(first);
  const auto arrow = arrowOf(rest.substr(0, 8));
  return std::string_view(":=)},;").find(rest.front()) != std::string_view::npos || (arrow && arrow->first == 0);
}

// `"F" -> "F+F"`, `'X': 'F[+X]'`; a `"` or `'` among modules stays
void blankQuotes(std::string& text) {
  for (const TextPiece& line : linesOf(text)) {
    // an apostrophe is a symbol in print: it quotes where it quotes a predecessor or an axiom, too
    const std::string_view front = line.text.substr(0, line.text.find('\''));
    const std::size_t last = front.find_last_not_of(" \t");
    const std::string_view marks =
        last == std::string_view::npos || std::string_view("{(,:;=").find(front[last]) != std::string_view::npos ? "\"'"
                                                                                                                 : "\"";
    for (std::size_t open = line.text.find_first_of(marks); open != std::string_view::npos;) {
      core::pollWork();
      const std::size_t close = line.text.find(line.text[open], open + 1);
      const bool isQuoted = close != std::string_view::npos && close > open + 1 &&
                            opensString(line.text.substr(0, open)) && closesString(line.text.substr(close + 1));
      if (isQuoted) {
        text[line.offset + open] = ' ';
        text[line.offset + close] = ' ';
      }
      open = line.text.find_first_of(marks, isQuoted ? close + 1 : open + 1);
    }
  }
}

// so many small words between blanks: no modules. A letter that is repeated is no word
bool isRemarkOfWords(std::string_view inside, std::size_t words) {
  std::size_t count = 0;
  for (std::size_t at = 0; at < inside.size();) {
    const std::size_t end = std::min(inside.find(' ', at), inside.size());
    const std::string_view word = inside.substr(at, end - at);
    const bool isWord =
        std::all_of(word.begin(), word.end(), [](char c) { return std::islower(static_cast<unsigned char>(c)) != 0; });
    if (!isWord) {
      return false;
    }
    count += word.size() > 2 && word.find_first_not_of(word.front()) != std::string_view::npos ? 1 : 0;
    at = end + 1;
  }
  return count >= words;
}

// `start : A {starting character string}`, `1 -> (eliminated at each iteration)`
void blankRemarksOfWords(std::string& text) {
  for (std::size_t open = text.find_first_of("{("); open != std::string::npos;
       open = text.find_first_of("{(", open + 1)) {
    core::pollWork();
    // a longer one is none, so that a line of brackets is read in linear time
    const std::size_t length = std::string_view(text).substr(open, 200).find(text[open] == '{' ? '}' : ')');
    const std::size_t close = length == std::string_view::npos ? std::string::npos : open + length;
    const bool isBehindBlank = open > 0 && (text[open - 1] == ' ' || text[open - 1] == '\t');
    if (close != std::string::npos && isBehindBlank &&
        // `{leaf bud}` may be a polygon
        isRemarkOfWords(std::string_view(text).substr(open + 1, close - open - 1), text[open] == '{' ? 3 : 2)) {
      blankOut(text, open, close + 1);
    }
  }
}

// a remark between the lines of a successor
void blankRemarks(std::string& text) {
  std::vector<TextPiece> remarks;
  (void)textbookStatements(text, &remarks);
  for (const TextPiece& remark : remarks) {
    blankOut(text, remark.offset, remark.offset + remark.text.size());
  }
}

// `F => F+F`; `x=>3` in a line with another arrow is left to its condition
void readFatArrows(std::string& text) {
  for (const TextPiece& line : linesOf(text)) {
    const std::size_t arrow = line.text.find("=>");
    if (arrow != std::string_view::npos && !arrowOf(line.text)) {
      text[line.offset + arrow] = '-';
    }
  }
}

}  // namespace

std::string plainTextbook(std::string_view text) {
  std::string plain(text);
  blankComments(plain);
  replaceSigns(plain);
  blankOuterBraces(plain);
  blankSetBraces(plain);
  readLatexSettings(plain);
  readLatex(plain);
  readFatArrows(plain);
  blankBullets(plain);
  blankQuotes(plain);
  blankRemarksOfWords(plain);
  markConditions(plain);
  markEqualsRules(plain);
  blankRemarks(plain);
  return plain;
}

}  // namespace espalier::language

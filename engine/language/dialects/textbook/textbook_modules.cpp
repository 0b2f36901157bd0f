#include "engine/language/dialects/textbook/textbook_modules.h"

#include <array>
#include <cctype>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/language/dialects/textbook/textbook_statements.h"
#include "engine/language/dialects/textbook/textbook_words.h"
#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

using Pair = std::pair<std::string_view, std::string_view>;

// signs that are printed as one character and mean another
constexpr std::array kSigns = {Pair{"−", "-"}, Pair{"–", "-"}, Pair{"—", "-"}, Pair{"ˆ", "^"}, Pair{"∧", "^"}};
constexpr std::array<std::string_view, 5> kNothing{"ε", "ϵ", "∅", "λ", "є"};
constexpr std::array kOperators = {
    Pair{"≤", "<="},  Pair{"≥", ">="},  Pair{"≠", "!="},  Pair{"∧", "&&"},  Pair{"∨", "||"},
    Pair{"−", "-"},   Pair{"·", "*"},   Pair{"×", "*"},   Pair{"⩽", "<="},  Pair{"⩾", ">="},
    Pair{"⋅", "*"},   Pair{"÷", "/"},   Pair{"&&", "&&"}, Pair{"||", "||"}, Pair{"<>", "!="},
    Pair{"°", ""},    Pair{"◦", ""},    Pair{"º", ""},    Pair{"²", "^2"},  Pair{"³", "^3"},
    Pair{"<=", "<="}, Pair{">=", ">="}, Pair{"==", "=="}, Pair{"!=", "!="}, Pair{"=", "=="}};
constexpr std::array kSubscripts = {Pair{"₀", "0"}, Pair{"₁", "1"}, Pair{"₂", "2"}, Pair{"₃", "3"}, Pair{"₄", "4"},
                                    Pair{"₅", "5"}, Pair{"₆", "6"}, Pair{"₇", "7"}, Pair{"₈", "8"}, Pair{"₉", "9"},
                                    Pair{"₊", "+"}, Pair{"₋", "-"}, Pair{"ₐ", "a"}, Pair{"ₑ", "e"}, Pair{"ₕ", "h"},
                                    Pair{"ᵢ", "i"}, Pair{"ⱼ", "j"}, Pair{"ₖ", "k"}, Pair{"ₗ", "l"}, Pair{"ₘ", "m"},
                                    Pair{"ₙ", "n"}, Pair{"ₒ", "o"}, Pair{"ₚ", "p"}, Pair{"ᵣ", "r"}, Pair{"ₛ", "s"},
                                    Pair{"ₜ", "t"}, Pair{"ᵤ", "u"}, Pair{"ᵥ", "v"}, Pair{"ₓ", "x"}};
constexpr std::string_view kLeafSign = "♠";
constexpr std::string_view kWedge = "∧";

template <std::size_t Count>
const Pair* pairAt(const std::array<Pair, Count>& pairs, std::string_view text) {
  for (const Pair& pair : pairs) {
    if (text.starts_with(pair.first)) {
      return &pair;
    }
  }
  return nullptr;
}

bool isLetter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

// `n`, `n+1`, `n - 1` or a whole number; else a name
Subscript subscriptOf(std::string text) {
  std::erase(text, ' ');
  for (std::size_t at = text.find("−"); at != std::string::npos; at = text.find("−")) {
    text.replace(at, std::string_view("−").size(), "-");
  }
  Subscript subscript;
  if (const auto number = core::parseNumber(text); number && isDigit(text.front())) {
    subscript.kind = Subscript::Kind::Number;
    subscript.shift = static_cast<int>(*number);
  } else if (text.starts_with('n') && (text.size() == 1 || text[1] == '+' || text[1] == '-')) {
    const auto shift = text.size() == 1 ? std::optional(0.0) : core::parseNumber(text.substr(text[1] == '+' ? 2 : 1));
    subscript.kind = shift ? Subscript::Kind::Level : Subscript::Kind::Name;
    subscript.shift = static_cast<int>(shift.value_or(0.0));
    subscript.name = text;
  } else {
    subscript.kind = Subscript::Kind::Name;
    subscript.name = text;
  }
  return subscript;
}

std::string levelText(const Subscript& subscript, int predecessorShift) {
  if (subscript.kind == Subscript::Kind::Number) {
    return std::to_string(subscript.shift);
  }
  const int difference = subscript.shift - predecessorShift;
  return difference == 0 ? "n" : (difference > 0 ? "n+" : "n") + std::to_string(difference);
}

}  // namespace

std::optional<double> textbookNumber(std::string_view text) {
  std::string plain = lowered(text);
  std::erase_if(plain, [](char c) { return c == ' ' || c == '\t' || c == '\r'; });
  double factor = 1.0;
  const auto dropEnd = [&](std::string_view end, double unit) {
    if (plain.size() > end.size() && plain.ends_with(end)) {
      plain.erase(plain.size() - end.size());
      factor = unit;
    }
  };
  constexpr double kDegreesPerRadian = 57.29577951308232;
  for (const std::string_view sign : {"°", "º", "◦", "˚", "^\\circ", "degrees", "degree", "deg"}) {
    dropEnd(sign, 1.0);
  }
  dropEnd("rad", kDegreesPerRadian);
  dropEnd("%", 0.01);
  // `π/3`, `2π/5`
  for (const std::string_view sign : {"π", "pi"}) {
    if (const std::size_t at = plain.find(sign); at != std::string::npos) {
      plain.replace(at, sign.size(), at == 0 ? "180" : "*180");
    }
  }
  std::replace(plain.begin(), plain.end(), ',', '.');
  // a product and one quotient
  const std::size_t slash = plain.find('/');
  std::string_view above = std::string_view(plain).substr(0, slash);
  if (const std::size_t star = above.find('*'); star != std::string_view::npos) {
    const auto first = core::parseNumber(above.substr(0, star));
    factor *= first.value_or(0.0);
    above = first ? above.substr(star + 1) : std::string_view{};
  }
  const auto numerator = core::parseNumber(above);
  if (!numerator || slash == std::string::npos) {
    return numerator ? std::optional(factor == 1.0 ? *numerator : *numerator * factor) : std::nullopt;
  }
  const auto below = core::parseNumber(std::string_view(plain).substr(slash + 1));
  return below && *below != 0.0 ? std::optional(factor == 1.0 ? *numerator / *below : *numerator * factor / *below)
                                : std::nullopt;
}

Subscript readSubscript(std::string_view text, std::size_t& at) {
  std::string small;
  const std::size_t begin = at;
  for (const Pair* sign = pairAt(kSubscripts, text.substr(std::min(at, text.size()))); sign != nullptr;
       sign = pairAt(kSubscripts, text.substr(at))) {
    small += sign->second;
    at += sign->first.size();
  }
  if (!small.empty()) {
    const Subscript subscript = subscriptOf(small);
    // a sign stands in levels only
    const bool isWrong = subscript.kind == Subscript::Kind::Name && small.find_first_of("+-") != std::string::npos;
    at = isWrong ? begin : at;
    return isWrong ? Subscript{} : subscript;
  }
  if (at + 1 >= text.size() || text[at] != '_') {
    return {};
  }
  if (text[at + 1] == '{') {
    const std::size_t end = text.find('}', at);
    if (end == std::string_view::npos) {
      return {};
    }
    const std::string inner(text.substr(at + 2, end - at - 2));
    at = end + 1;
    return inner.empty() ? Subscript{} : subscriptOf(inner);
  }
  if (!isLetter(text[at + 1]) && !isDigit(text[at + 1])) {
    return {};
  }
  std::size_t end = at + 2;
  while (isDigit(text[at + 1]) && end < text.size() && isDigit(text[end])) {
    ++end;
  }
  const std::string inner(text.substr(at + 1, end - at - 1));
  at = end;
  return subscriptOf(inner);
}

MappedText TextbookModules::modules(const TextPiece& piece, int predecessorShift, bool isDrawing) {
  MappedText result;
  const std::string_view text = piece.text;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = at;
    const std::size_t offset = piece.offset + begin;
    const char c = text[at];
    if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
      ++at;
      continue;
    }
    const std::string_view word = wordAt(text.substr(begin), symbols_.words);
    std::string symbol(word.empty() ? text.substr(begin, 1) : word);
    at += word.empty() ? characterLength(c) : word.size();
    if (!word.empty()) {
      // a symbol of several letters
    } else if (const Pair* sign = pairAt(kSigns, text.substr(begin))) {
      symbol = sign->second;
    } else if (text.substr(begin).starts_with(kLeafSign)) {
      symbols_.hasLeaf = true;
      result.make("@o(0.4)", offset);
      continue;
    } else if (std::any_of(kNothing.begin(), kNothing.end(),
                           [&](std::string_view nothing) { return text.substr(begin).starts_with(nothing); })) {
      continue;
    } else if (static_cast<unsigned char>(c) > 126 || c < ' ' ||
               std::string_view("<>:*()").find(c) != std::string_view::npos) {
      const std::size_t length = std::min(characterLength(c), text.size() - begin);
      report_.error(offset, length,
                    "the character '" + std::string(text.substr(begin, length)) + "' cannot be a module here",
                    c == '(' ? "parameters stand directly behind their symbol"
                             : "a module is a letter or a sign of the turtle, with parameters in parentheses");
      at = begin + length;
      continue;
    }
    // `0.3` or ` .3`: a number, and no vertex of a polygon between digits
    if (c == '.' && at < text.size() && isDigit(text[at]) &&
        (begin == 0 || isDigit(text[begin - 1]) || text[begin - 1] == ' ')) {
      const std::size_t last = std::min(text.find_first_not_of("0123456789", at), text.size());
      const std::size_t first = text.substr(0, begin).find_last_not_of("0123456789") + 1;
      report_.error(piece.offset + first, last - first,
                    "the number " + std::string(text.substr(first, last - first)) + " cannot be a module",
                    "a probability stands behind the production, as in 'F → F[+F]F : 0.33'");
      at = last;
      continue;
    }
    const bool isExchanged = isDrawing && (symbol == "/" || symbol == "\\");
    if (isExchanged) {
      symbol = symbol == "/" ? "\\" : "/";
    }
    // two slashes in a row would begin a comment
    if (symbol == "/" && std::string_view(result.text()).ends_with('/')) {
      result.make(" ", offset);
    }
    const Subscript subscript = isLetter(c) && word.empty() ? readSubscript(text, at) : Subscript{};
    const bool hasParameters = at < text.size() && text[at] == '(';
    if (symbol.size() == 1) {
      symbols_.all.insert(symbol.front());
    }
    if (subscript.kind == Subscript::Kind::Name) {
      symbol += "_" + subscript.name;
      symbols_.names.insert(symbol);
    }
    if (subscript.kind == Subscript::Kind::Level || subscript.kind == Subscript::Kind::Number) {
      symbols_.levelled.insert(symbol);
      result.make(symbol + "(" + levelText(subscript, predecessorShift) + ")", offset);
      continue;
    }
    if (symbol == text.substr(begin, symbol.size())) {
      result.copy(symbol, offset);
    } else {
      result.make(symbol, offset);
    }
    if (symbol.size() == 1 && !isExchanged) {
      (hasParameters ? symbols_.numbered : symbols_.plain).insert(symbol.front());
    }
    if (!hasParameters) {
      continue;
    }
    // parameters up to the parenthesis that closes the list
    std::size_t end = at;
    int depth = 0;
    do {
      depth += text[end] == '(' ? 1 : text[end] == ')' ? -1 : 0;
      ++end;
    } while (end < text.size() && depth > 0);
    if (depth > 0) {
      report_.error(piece.offset + at, 1, "the parenthesis '(' of " + symbol + " is never closed",
                    "the parameters of a module stand between '(' and ')'");
    }
    const bool isTurn = symbol.size() == 1 && std::string_view("+-&^/\\").find(symbol) != std::string_view::npos;
    appendParameters(result, {text.substr(at, end - at), piece.offset + at}, isTurn);
    at = end;
  }
  return result;
}

void TextbookModules::setFormals(const TextPiece& predecessor) {
  formals_.clear();
  int depth = 0;
  for (std::size_t at = 0; at < predecessor.text.size();) {
    const char c = predecessor.text[at];
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    std::string name = depth > 0 ? readTextbookName(predecessor.text, at) : std::string{};
    if (name.empty()) {
      ++at;
    } else {
      formals_.insert(std::move(name));
    }
  }
}

MappedText TextbookModules::condition(const TextPiece& piece) {
  MappedText result;
  appendExpression(result, piece, true);
  return result;
}

MappedText TextbookModules::expression(const TextPiece& piece) {
  MappedText result;
  appendExpression(result, piece, false);
  return result;
}

void TextbookModules::appendExpression(MappedText& result, const TextPiece& piece, bool isCondition) const {
  const std::string_view text = piece.text;
  char previous = '(';  // the last character that is not a blank
  bool isInString = false;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    const std::size_t offset = piece.offset + at;
    const bool isSign = static_cast<unsigned char>(c) > 126;
    isInString = isInString != (c == '"');
    // a blank behind another, or behind the parenthesis of a sign of print
    if (c == ' ' && !isInString && (result.text().ends_with(' ') || result.text().ends_with('('))) {
      ++at;
      continue;
    }
    // in print one sign is a power, and "and" between conditions
    if (!isCondition && text.substr(at).starts_with(kWedge)) {
      result.make("^", offset);
      at += kWedge.size();
      previous = '=';
      continue;
    }
    const Pair* found = isCondition || isSign ? pairAt(kOperators, text.substr(at)) : nullptr;
    if (found != nullptr) {
      result.make(found->second, offset);
      at += found->first.size();
      previous = '=';
      continue;
    }
    std::size_t end = at;
    const std::string name = readTextbookName(text, end);
    end = name.empty() ? at + 1 : end;
    const std::string word(text.substr(at, end - at));
    const bool isOperand = isLetter(previous) || isDigit(previous) || previous == ')' || previous == '.';
    const bool isFormal = formals_.count(name) > 0;
    const auto constant = name.empty() || isFormal ? constants_.end() : constants_.find(name);
    if (constant != constants_.end()) {
      const bool isNumber = constant->second.find_first_not_of("0123456789.") == std::string::npos;
      result.make(isNumber ? constant->second : "(" + constant->second + ")", offset);
      previous = ')';
    } else if (painter_.areRead && word == "%" && !isOperand) {
      result.make("floor(ran(100))", offset);
      previous = ')';
    } else if (painter_.areRead && word == "t" && !isFormal) {
      result.make("Q", offset);
      previous = 'Q';
    } else if (isCondition && (word == "&" || word == "|") && previous != c) {
      result.make(word + word, offset);
      previous = c;
    } else if (isCondition && (word == "and" || word == "or" || word == "not") && !isFormal) {
      result.make(word == "and" ? "&&" : word == "or" ? "||" : "!", offset);
      previous = '=';
    } else if (!name.empty() && name != word) {
      result.make(name, offset);
      previous = 'x';
    } else if (isSign && !isInString) {
      const std::size_t length = std::min(characterLength(c), text.size() - at);
      report_.error(offset, length,
                    "the character '" + std::string(text.substr(at, length)) + "' cannot stand in an expression",
                    "expressions have numbers, names, + - * / ^ and parentheses");
      end = at + length;
    } else {
      result.copy(text.substr(at, end - at), offset);
      previous = c == ' ' || c == '\t' ? previous : text[end - 1];
    }
    at = end;
  }
}

void TextbookModules::appendParameters(MappedText& result, const TextPiece& piece, bool isTurn) const {
  // a comma of its own list separates the bounds of a random angle
  std::vector<std::size_t> commas;
  int depth = 0;
  for (std::size_t i = 0; i < piece.text.size(); ++i) {
    depth += piece.text[i] == '(' ? 1 : piece.text[i] == ')' ? -1 : 0;
    if (piece.text[i] == ',' && depth == 1) {
      commas.push_back(i);
    }
  }
  if (!painter_.areRead || !isTurn || commas.size() != 1 || !piece.text.ends_with(')')) {
    return appendExpression(result, piece, false);
  }
  const TextPiece least = piece.to(commas.front()).from(1);
  const TextPiece most = piece.to(piece.text.size() - 1).from(commas.front() + 1);
  result.make("((", piece.offset);
  appendExpression(result, least, false);
  result.make(")+ran((", least.offset);
  appendExpression(result, most, false);
  result.make(")-(", most.offset);
  appendExpression(result, least, false);
  result.make(")))", most.offset);
}

std::optional<TextbookModules::Levelled> TextbookModules::levelled(const TextPiece& piece) {
  const TextPiece trimmed = piece.trimmed();
  if (trimmed.empty() || !isLetter(trimmed.text.front())) {
    return std::nullopt;
  }
  std::size_t at = 1;
  Subscript subscript = readSubscript(trimmed.text, at);
  const bool isLevel = subscript.kind == Subscript::Kind::Level || subscript.kind == Subscript::Kind::Number;
  if (!isLevel || at != trimmed.text.size()) {
    return std::nullopt;
  }
  return Levelled{std::string(1, trimmed.text.front()), std::move(subscript)};
}

}  // namespace espalier::language

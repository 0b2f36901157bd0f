#include "engine/language/dialects/textbook/textbook_words.h"

#include <algorithm>
#include <cctype>

#include "engine/language/dialects/textbook/textbook_modules.h"
#include "engine/language/dialects/textbook/textbook_statements.h"

namespace espalier::language {
namespace {

constexpr std::size_t kShortestWord = 3;

bool isLatinLetter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

bool hasSmallLetter(std::string_view run) {
  return std::any_of(run.begin(), run.end(), [](char c) { return std::islower(static_cast<unsigned char>(c)) != 0; });
}

// the runs of letters outside of parentheses that are words
std::vector<std::string_view> wordsOf(std::string_view text) {
  std::vector<std::string_view> words;
  int depth = 0;
  for (std::size_t at = 0; at < text.size();) {
    depth += text[at] == '(' ? 1 : text[at] == ')' ? -1 : 0;
    std::size_t end = at;
    while (end < text.size() && isLatinLetter(text[end])) {
      ++end;
    }
    const std::string_view run = text.substr(at, end - at);
    const bool isSubscript = (at > 0 && text[at - 1] == '_') || (end < text.size() && text[end] == '_');
    if (depth == 0 && !isSubscript && run.size() >= kShortestWord && hasSmallLetter(run)) {
      words.push_back(run);
    }
    at = std::max(end, at + 1);
  }
  return words;
}

// the words of predecessors and contexts, without conditions
std::vector<std::string_view> predecessorWords(const TextPiece& statement) {
  std::vector<std::string_view> words;
  const auto setting = settingOf(statement);
  for (const TextPiece& part : productionsOf(setting ? setting->value : statement)) {
    const TextPiece production = withoutLabel(part);
    if (const auto arrow = arrowOf(production.text)) {
      const std::size_t end = std::min(arrow->first, production.text.find_first_of(":;"));
      const std::vector<std::string_view> found = wordsOf(production.text.substr(0, end));
      words.insert(words.end(), found.begin(), found.end());
    }
  }
  return words;
}

// `.5`, `1/3`, `50%`, `1`: no other whole number
bool isProbability(std::string_view number) {
  const bool isPart = number.find_first_of("./%") != std::string_view::npos || number == "1";
  return isPart && textbookNumber(number).has_value();
}

std::string_view trimmedText(std::string_view text) {
  return TextPiece{text, 0}.trimmed().text;
}

// a number behind an operator belongs to the condition
bool endsOperand(std::string_view text) {
  return !text.empty() && (isLatinLetter(text.back()) || std::isdigit(static_cast<unsigned char>(text.back())) != 0 ||
                           text.back() == ')' || text.back() == ']');
}

TextPiece withoutDashes(const TextPiece& left) {
  const std::size_t last = left.text.find_last_not_of("- ");
  return left.to(last == std::string_view::npos ? 0 : last + 1);
}

// `F (0.5)`, and `F -(0.5)` joined to the arrow; `F(0.5)` has a parameter
TextPiece takeBracketed(TextPiece& left, bool isJoined) {
  const std::size_t open = left.text.ends_with(')') ? left.text.rfind('(') : std::string_view::npos;
  if (open == std::string_view::npos) {
    return {};
  }
  const TextPiece number = left.from(open + 1).to(left.text.size() - open - 2).trimmed();
  const TextPiece front = left.to(open).trimmed();
  const TextPiece rest = isJoined ? withoutDashes(front) : front;
  const bool isInArrow = rest.text.size() < front.text.size();
  const bool isBehindBlank = front.text.size() < open || isInArrow;
  const bool hasCondition = conditionMark(left.text) != std::string_view::npos;
  if (!isBehindBlank || rest.empty() || !isProbability(number.text) || (hasCondition && !endsOperand(rest.text))) {
    return {};
  }
  left = rest;
  return number;
}

// `F .5`, and `F -.5` joined to the arrow
TextPiece takeNumber(TextPiece& left, bool isJoined) {
  const std::size_t last = left.text.find_last_not_of("0123456789./% ");
  if (last == std::string_view::npos) {
    return {};
  }
  const bool isInArrow =
      isJoined && left.text[last] == '-' && conditionMark(left.text) == std::string_view::npos && last > 0;
  const std::string_view end = left.text.substr(last + 1);
  const std::size_t begin = end.starts_with('.') || isInArrow ? 0 : end.find(' ');
  if (begin == std::string_view::npos || (!isInArrow && !endsOperand(left.text.substr(0, last + 1)))) {
    return {};
  }
  const TextPiece number = left.from(last + 1 + begin).trimmed();
  if (!isProbability(number.text)) {
    return {};
  }
  const TextPiece rest = left.to(last + 1 + begin).trimmed();
  left = isInArrow ? withoutDashes(rest) : rest;
  return number;
}

}  // namespace

std::size_t conditionMark(std::string_view left) {
  int depth = 0;
  for (std::size_t at = 0; at < left.size(); ++at) {
    depth += left[at] == '(' ? 1 : left[at] == ')' ? -1 : 0;
    // a comma behind parameters and before a comparison, `A(x), x < 3`, or before a number, `A, 0.3`
    const std::string_view rest = left.substr(at + 1);
    const bool isCompared = at > 0 && left[at - 1] == ')' && rest.find_first_of("<>=") != std::string_view::npos;
    const bool isComma = left[at] == ',' && at > 0 && (isCompared || isProbability(trimmedText(rest)));
    if (depth == 0 && (left[at] == ':' || left[at] == ';' || isComma)) {
      return at;
    }
  }
  return std::string_view::npos;
}

TextPiece takeProbability(TextPiece& left, bool isJoined) {
  // a condition that is a number
  if (const std::size_t mark = conditionMark(left.text); mark != std::string_view::npos) {
    const TextPiece number = left.from(mark + 1).trimmed();
    if (number.text != "1" && isProbability(number.text)) {
      left = left.to(mark).trimmed();
      return number;
    }
  }
  const TextPiece bracketed = takeBracketed(left, isJoined);
  return bracketed.empty() ? takeNumber(left, isJoined) : bracketed;
}

TextPiece takeFrontProbability(TextPiece& right) {
  const std::size_t end = right.text.find(' ');
  if (end == std::string_view::npos || right.text.find_first_not_of("0123456789./%") != end) {
    return {};
  }
  const TextPiece number = right.to(end);
  if (number.text.find_first_of(".%") == std::string_view::npos || !textbookNumber(number.text)) {
    return {};
  }
  right = right.from(end).trimmed();
  return number;
}

void markConditions(std::string& text) {
  std::vector<std::pair<std::size_t, std::size_t>> words;  // offset, size
  for (const TextPiece& line : linesOf(text)) {
    const auto arrow = arrowOf(line.text);
    const std::string_view left = line.text.substr(0, arrow ? arrow->first : 0);
    for (const std::string_view word : {" where ", " if ", " when "}) {
      const std::size_t at = left.find(word);
      if (at != std::string_view::npos && left.find_first_of("<>=", at) != std::string_view::npos &&
          left.substr(0, at).ends_with(')')) {
        words.emplace_back(line.offset + at + 1, word.size() - 2);
      }
    }
  }
  for (const auto& [offset, size] : words) {
    text.replace(offset, size, ":" + std::string(size - 1, ' '));
  }
}

TextPiece takeEndProbability(TextPiece& right) {
  const std::size_t blank = right.text.rfind(' ');
  // behind a colon it is read elsewhere
  if (blank == std::string_view::npos || !right.text.ends_with('%') || right.to(blank).trimmed().text.ends_with(':')) {
    return {};
  }
  const TextPiece number = right.from(blank + 1);
  if (number.text.find_first_not_of("0123456789.%") != std::string_view::npos || !textbookNumber(number.text)) {
    return {};
  }
  right = right.to(blank).trimmed();
  return number;
}

std::set<std::string, std::less<>> textbookWords(const std::vector<TextPiece>& statements) {
  std::set<std::string, std::less<>> words;
  for (const TextPiece& statement : statements) {
    for (const std::string_view word : predecessorWords(statement)) {
      words.emplace(word);
    }
  }
  if (words.empty()) {
    return words;
  }
  for (const TextPiece& statement : statements) {
    if (const auto arrow = arrowOf(statement.text)) {
      for (const std::string_view word : wordsOf(statement.text.substr(arrow->first))) {
        // `Fseg` without a blank is a letter and a word
        if (std::none_of(word.begin(), word.end(),
                         [](char c) { return std::isupper(static_cast<unsigned char>(c)); })) {
          words.emplace(word);
        }
      }
    }
  }
  return words;
}

std::string_view wordAt(std::string_view text, const std::set<std::string, std::less<>>& words) {
  std::string_view longest;
  for (const std::string& word : words) {
    if (word.size() > longest.size() && text.starts_with(word)) {
      longest = word;
    }
  }
  return longest;
}

std::set<std::string_view> wordsOfPredecessors(std::string_view text) {
  std::set<std::string_view> predecessors;
  for (const TextPiece& line : linesOf(text)) {
    for (const std::string_view word : predecessorWords(line.trimmed())) {
      predecessors.insert(word);
    }
  }
  return predecessors;
}

bool isRemark(std::string_view behindSlashes, const std::set<std::string_view>& predecessors) {
  const std::vector<std::string_view> words = wordsOf(behindSlashes);
  if (words.empty()) {
    // `- - //` at the end of a line, `// A`; `// do it` is a remark
    return std::adjacent_find(behindSlashes.begin(), behindSlashes.end(), [](char a, char b) {
             return std::islower(static_cast<unsigned char>(a)) != 0 &&
                    std::islower(static_cast<unsigned char>(b)) != 0;
           }) != behindSlashes.end();
  }
  const bool areSymbols =
      std::all_of(words.begin(), words.end(), [&](std::string_view word) { return predecessors.contains(word); });
  // brackets, or two rolls between modules once more
  const bool hasSigns = behindSlashes.find_first_of("[]{}") != std::string_view::npos ||
                        behindSlashes.find(" // ") != std::string_view::npos;
  return !areSymbols && (predecessors.empty() || !hasSigns);
}

std::optional<double> angleOfSentence(std::string_view text) {
  const std::size_t end = std::min(text.find("°"), text.find("◦"));
  if (end == std::string_view::npos || text.find("δ") == std::string_view::npos) {
    return std::nullopt;
  }
  const std::size_t begin = text.substr(0, end).find_last_not_of("0123456789., ") + 1;
  return textbookNumber(text.substr(begin, end - begin));
}

bool isProse(std::string_view text) {
  const std::size_t blank = text.find(' ');
  const auto isWordLetter = [](char c) { return isLatinLetter(c) || static_cast<unsigned char>(c) >= 0x80; };
  std::size_t longest = 0;
  std::size_t length = 0;
  for (const char c : text) {
    length = isWordLetter(c) ? length + 1 : 0;
    longest = std::max(longest, length);
  }
  return blank != std::string_view::npos && longest >= 4 && text.find_first_of("[]{}|+") == std::string_view::npos;
}

std::string directiveAdvice(std::string_view directive, std::string_view text) {
  if (directive.starts_with("include \"") || directive.starts_with("include <")) {
    return "put the lines of the file here";
  }
  const bool isConditional = directive.starts_with("if") && text.find("#endif") != std::string_view::npos;
  return isConditional ? "every line up to '#endif' is read" : std::string();
}

}  // namespace espalier::language

#include "engine/language/dialects/textbook_words.h"

#include <algorithm>
#include <cctype>

#include "engine/language/dialects/textbook_statements.h"

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

}  // namespace

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

bool isRemark(std::string_view behindSlashes, std::string_view whole) {
  const std::vector<std::string_view> words = wordsOf(behindSlashes);
  if (words.empty()) {
    // `- - //` at the end of a line, `// A`; `// do it` is a remark
    return std::adjacent_find(behindSlashes.begin(), behindSlashes.end(), [](char a, char b) {
             return std::islower(static_cast<unsigned char>(a)) != 0 &&
                    std::islower(static_cast<unsigned char>(b)) != 0;
           }) != behindSlashes.end();
  }
  std::set<std::string_view> predecessors;
  for (const TextPiece& line : linesOf(whole)) {
    for (const std::string_view word : predecessorWords(line.trimmed())) {
      predecessors.insert(word);
    }
  }
  const bool areSymbols =
      std::all_of(words.begin(), words.end(), [&](std::string_view word) { return predecessors.contains(word); });
  const bool hasBrackets = behindSlashes.find_first_of("[]{}") != std::string_view::npos;
  return !areSymbols && (predecessors.empty() || !hasBrackets);
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

}  // namespace espalier::language

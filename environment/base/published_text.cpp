#include "environment/base/published_text.h"

#include <algorithm>

#include "engine/core/number_text.h"
#include "engine/files/utf8.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::string_view kDigits = "0123456789";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

core::Diagnostic warning(const core::SourceLocation& location, std::string message, std::string hint) {
  return {core::Severity::Warning, std::move(message), location, std::move(hint)};
}

/// Length of the longest decimal number at the beginning of a word; 0: none.
std::size_t numberLength(std::string_view word) {
  const auto digitsFrom = [&](std::size_t begin) {
    return std::min(word.find_first_not_of(kDigits, begin), word.size()) - begin;
  };
  const std::size_t sign = !word.empty() && (word[0] == '+' || word[0] == '-') ? 1 : 0;
  const std::size_t before = digitsFrom(sign);
  std::size_t end = sign + before;
  if (end < word.size() && word[end] == '.') {
    const std::size_t after = digitsFrom(end + 1);
    end += before + after > 0 ? 1 + after : 0;
  }
  if (end == sign) {
    return 0;
  }
  if (end < word.size() && (word[end] == 'e' || word[end] == 'E')) {
    const std::size_t exponent = end + 1 + (end + 1 < word.size() && (word[end + 1] == '+' || word[end + 1] == '-'));
    const std::size_t digits = exponent < word.size() ? digitsFrom(exponent) : 0;
    end = digits > 0 ? exponent + digits : end;
  }
  return end;
}

/// Whether a line begins with a word that is a number and nothing else.
bool beginsWithNumber(std::string_view content) {
  const std::string_view word = firstPublishedWord(content);
  return !word.empty() && numberLength(word) == word.size();
}

core::SourceLocation locationOf(const std::string& file, std::uint32_t line, std::string_view text, std::size_t column,
                                std::size_t length) {
  core::SourceLocation location;
  location.file = file;
  location.line = line;
  location.column = static_cast<std::uint32_t>(column + 1);
  location.length = static_cast<std::uint32_t>(std::max<std::size_t>(length, 1));
  location.lineText = std::string(text);
  return location;
}

}  // namespace

std::vector<PublishedLine> readPublishedLines(const std::string& file, std::string_view bytes,
                                              std::vector<core::Diagnostic>& warnings) {
  const std::string decoded = files::asUtf8(bytes);
  std::string_view text = decoded;
  std::vector<PublishedLine> lines;
  std::uint32_t number = 0;
  while (!text.empty()) {
    const std::size_t newline = text.find('\n');
    std::string_view line = text.substr(0, newline);
    text.remove_prefix(newline == std::string_view::npos ? text.size() : newline + 1);
    ++number;
    if (!line.empty() && line.back() == '\r') {
      line.remove_suffix(1);
    }
    if (line.size() > kLongestPublishedLine) {
      warnings.push_back(
          warning(locationOf(file, number, line.substr(0, kLongestPublishedLine), kLongestPublishedLine - 1, 1),
                  "line longer than 254 characters: the rest is ignored",
                  "write the values in a shorter form: the published programs read no longer lines"));
      line = line.substr(0, kLongestPublishedLine);
    }
    const std::string_view content = trimmed(line);
    if (content.empty()) {
      continue;
    }
    // a line that begins with a number belongs to the keyword above it
    if (!lines.empty() && beginsWithNumber(content)) {
      lines.back().data.emplace_back(content);
      lines.back().dataLocations.push_back(
          locationOf(file, number, line, line.find_first_not_of(kBlanks), content.size()));
      continue;
    }
    const std::size_t separator = line.find_first_of("\t:");
    if (separator == std::string_view::npos) {
      warnings.push_back(warning(locationOf(file, number, line, 0, line.size()), "line without a keyword is ignored",
                                 "expected 'keyword: values'"));
      continue;
    }
    lines.push_back({std::string(line.substr(0, separator)),
                     std::string(trimmed(line.substr(separator + 1))),
                     locationOf(file, number, line, 0, separator),
                     {},
                     {}});
  }
  return lines;
}

core::SourceLocation valueLocation(const PublishedLine& line) {
  core::SourceLocation location = line.location;
  const std::size_t at =
      line.value.empty() ? std::string::npos : location.lineText.find(line.value, line.keyword.size() + 1);
  if (at != std::string::npos) {
    location.column = static_cast<std::uint32_t>(at + 1);
    location.length = static_cast<std::uint32_t>(line.value.size());
  }
  return location;
}

std::vector<double> readPublishedNumbers(std::string_view text, bool* areWhole, std::string_view separators) {
  std::vector<double> numbers;
  for (std::size_t begin = text.find_first_not_of(separators); begin != std::string_view::npos;
       begin = text.find_first_not_of(separators)) {
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    const std::size_t length = numberLength(word);
    numbers.push_back(core::parseNumber(word.substr(0, length)).value_or(0.0));
    if (areWhole != nullptr && (length == 0 || length < word.size())) {
      *areWhole = false;
    }
    text = text.substr(end);
  }
  return numbers;
}

std::string_view firstPublishedWord(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kPublishedSeparators);
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_first_of(kPublishedSeparators, begin) - begin);
}

std::vector<std::string> readPublishedWords(std::string_view text) {
  std::vector<std::string> words;
  while (true) {
    const std::size_t begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) {
      return words;
    }
    const std::size_t end = std::min(text.find_first_of(kBlanks, begin), text.size());
    words.emplace_back(text.substr(begin, end - begin));
    text = text.substr(end);
  }
}

std::string besideFile(const std::string& file, const std::string& name) {
  const std::size_t slash = file.rfind('/');
  if (slash == std::string::npos || (!name.empty() && name.front() == '/')) {
    return name;
  }
  return file.substr(0, slash + 1) + name;
}

}  // namespace espalier::environment

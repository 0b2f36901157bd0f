#include "environment/base/published_text.h"

#include <algorithm>

#include "engine/core/number_text.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::string_view kNumberSeparators = "x,;: \t\r";

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

std::vector<PublishedLine> readPublishedLines(const std::string& file, std::string_view text, PublishedSyntax syntax,
                                              std::vector<core::Diagnostic>& warnings) {
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
    if (!lines.empty() && !readPublishedNumbers(content.substr(0, content.find_first_of(kNumberSeparators))).empty()) {
      lines.back().data.emplace_back(content);
      continue;
    }
    const std::size_t separator = syntax == PublishedSyntax::Environment ? line.find_first_of("\t:") : line.find(':');
    if (separator == std::string_view::npos) {
      warnings.push_back(warning(locationOf(file, number, line, 0, line.size()), "line without a keyword is ignored",
                                 "expected 'keyword: values'"));
      continue;
    }
    lines.push_back({std::string(line.substr(0, separator)),
                     std::string(trimmed(line.substr(separator + 1))),
                     locationOf(file, number, line, 0, separator),
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

std::vector<double> readPublishedNumbers(std::string_view text, std::string_view* rest) {
  std::vector<double> numbers;
  while (true) {
    const std::size_t begin = text.find_first_not_of(kNumberSeparators);
    if (begin == std::string_view::npos) {
      text = {};
      break;
    }
    const std::size_t end = std::min(text.find_first_of(kNumberSeparators, begin), text.size());
    std::string_view word = text.substr(begin, end - begin);
    if (word.front() == '+') {
      word.remove_prefix(1);
    }
    const auto number = core::parseNumber(word);
    if (!number) {
      text = text.substr(begin);
      break;
    }
    numbers.push_back(*number);
    text = text.substr(end);
  }
  if (rest != nullptr) {
    *rest = text;
  }
  return numbers;
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

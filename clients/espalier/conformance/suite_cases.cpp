#include "clients/espalier/conformance/suite_cases.h"

#include <charconv>
#include <sstream>
#include <utility>

namespace espalier::conformance {
namespace {

constexpr std::size_t kColumns = 6;       // that every line of the table has
constexpr std::size_t kChecksColumn = 7;  // the sentence
constexpr std::size_t kShown = 600;       // characters of a string in a message
constexpr std::size_t kShownLine = 60;    // characters of a line in a message

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) {
    parts.push_back(part);
  }
  return parts;
}

template <typename Number>
bool read(const std::string& text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

}  // namespace

std::optional<std::vector<ConformanceCase>> readCases(const std::string& table) {
  std::vector<ConformanceCase> cases;
  for (const std::string& line : split(table, '\n')) {
    const std::vector<std::string> column = split(line, '\t');
    if (column.empty() || column[0] == "case") {
      continue;
    }
    ConformanceCase entry;
    double tolerance = 0.0;
    if (column.size() < kColumns || !read(column[2], entry.steps) || !read(column[3], tolerance)) {
      return std::nullopt;
    }
    entry.name = column[0];
    entry.kind = column[1];
    // the usual tolerance is relative, any other is absolute
    if (column[3] != "1e-5") {
      entry.tolerance = {.relative = 0.0, .absolute = tolerance};
    }
    entry.isQuirk = column[4] == "yes";
    entry.hasTurtleFile = column[5] == "yes";
    entry.checks = column.size() > kChecksColumn ? column[kChecksColumn] : "";
    cases.push_back(std::move(entry));
  }
  return cases;
}

std::string compareSteps(const std::vector<std::string>& strings, const std::string& expectedText, const char* which,
                         const Tolerance& tolerance, Deviation& largest) {
  const std::vector<std::string> lines = split(expectedText, '\n');
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::size_t tab = lines[i].find('\t');
    const std::string expected = tab == std::string::npos ? "" : lines[i].substr(tab + 1);
    const std::string step = std::string(which) + " string of step " + std::to_string(i);
    if (i >= strings.size()) {
      return step + ": missing, the run ended before";
    }
    Deviation deviation;
    const auto difference = firstDifference(expected, strings[i], tolerance, deviation);
    if (deviation.share > largest.share) {
      largest = {deviation.share, step + ", " + deviation.place};
    }
    if (difference) {
      return step + ": " + *difference + "\n  expected: " + expected.substr(0, kShown) +
             "\n  actual:   " + strings[i].substr(0, kShown);
    }
  }
  if (strings.size() != lines.size()) {
    return std::string(which) + " strings: expected " + std::to_string(lines.size()) + " steps, actual " +
           std::to_string(strings.size());
  }
  return {};
}

std::optional<std::vector<std::string>> readSteps(const std::string& output, std::string& problem) {
  std::vector<std::string> strings;
  for (const std::string& line : split(output, '\n')) {
    const std::string number = std::to_string(strings.size());
    if (!line.starts_with(number + "\t")) {
      problem = "line " + std::to_string(strings.size() + 1) + " of its output is '" + line.substr(0, kShownLine) +
                "': expected '" + number + "', a TAB, and the string of step " + number;
      return std::nullopt;
    }
    strings.push_back(line.substr(number.size() + 1));
    if (strings.back().ends_with('\r')) {
      strings.back().pop_back();
    }
  }
  return strings;
}

}  // namespace espalier::conformance

#include "clients/espalier/conformance/string_comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace espalier::conformance {
namespace {

// how far two numbers are apart, as a share of what the tolerance allows; beyond 1 they differ
double shareOf(double expected, double actual, const Tolerance& tolerance) {
  if (!std::isfinite(expected) || !std::isfinite(actual)) {
    return std::numeric_limits<double>::infinity();
  }
  return std::abs(expected - actual) /
         (tolerance.relative * std::max(std::abs(expected), std::abs(actual)) + tolerance.absolute);
}

// a module that both strings have: its symbol, number of parameters and numbers
std::optional<std::string> moduleDifference(const TextModule& expected, const TextModule& actual,
                                            const Tolerance& tolerance, std::size_t index, Deviation& largest) {
  const std::string both = "expected " + expected.text + ", actual " + actual.text;
  if (expected.symbol != actual.symbol) {
    return "other symbol: " + both;
  }
  if (expected.parameters.size() != actual.parameters.size()) {
    return "other number of parameters: " + both;
  }
  for (std::size_t k = 0; k < expected.parameters.size(); ++k) {
    const double share = shareOf(expected.parameters[k], actual.parameters[k], tolerance);
    if (!(share <= 1.0)) {
      return "parameter " + std::to_string(k + 1) + " differs: " + both;
    }
    if (share > largest.share) {
      largest = {share, "module " + std::to_string(index) + ": " + both};
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::vector<TextModule>> splitModules(std::string_view text, std::string& problem) {
  std::vector<TextModule> modules;
  std::size_t i = 0;
  while (i < text.size()) {
    TextModule module;
    const std::size_t begin = i;
    module.symbol = text[i++];
    if (i < text.size() && text[i] == '(') {
      const std::size_t end = text.find(')', i);
      if (end == std::string_view::npos) {
        problem = "the parameter list of module " + std::to_string(modules.size()) + " has no end";
        return std::nullopt;
      }
      // numbers between commas
      std::size_t from = i + 1;
      while (from <= end) {
        const std::size_t to = std::min(text.find(',', from), end);
        const std::string number(text.substr(from, to - from));
        char* rest = nullptr;
        module.parameters.push_back(std::strtod(number.c_str(), &rest));
        if (number.empty() || *rest != '\0') {
          problem = "'" + number + "' in module " + std::to_string(modules.size()) + " is not a number";
          return std::nullopt;
        }
        from = to + 1;
      }
      i = end + 1;
    }
    module.text = text.substr(begin, i - begin);
    modules.push_back(std::move(module));
  }
  return modules;
}

std::optional<std::string> firstDifference(std::string_view expected, std::string_view actual,
                                           const Tolerance& tolerance, Deviation& largest) {
  std::string problem;
  const auto expectedModules = splitModules(expected, problem);
  if (!expectedModules) {
    return "expected string: " + problem;
  }
  const auto actualModules = splitModules(actual, problem);
  if (!actualModules) {
    return "actual string: " + problem;
  }
  const std::size_t common = std::min(expectedModules->size(), actualModules->size());
  for (std::size_t i = 0; i < common; ++i) {
    if (const auto difference = moduleDifference((*expectedModules)[i], (*actualModules)[i], tolerance, i, largest)) {
      return "module " + std::to_string(i) + ": " + *difference;
    }
  }
  if (expectedModules->size() != actualModules->size()) {
    return "expected " + std::to_string(expectedModules->size()) + " modules, actual " +
           std::to_string(actualModules->size());
  }
  return std::nullopt;
}

}  // namespace espalier::conformance

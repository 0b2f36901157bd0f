#pragma once

#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "clients/espalier/conformance/string_comparison.h"

namespace espalier::conformance {

/// One line of cases.tsv.
struct ConformanceCase {
  std::string name;
  std::string kind;  // deterministic, stochastic, random, environment
  std::uint64_t steps = 0;
  Tolerance tolerance;
  bool isQuirk = false;
  bool hasTurtleFile = false;
  std::string checks;  // a sentence
};

inline std::ostream& operator<<(std::ostream& stream, const ConformanceCase& entry) {
  return stream << entry.name;
}

/// The cases of a table (cases.tsv) in its order. Nothing when a line has too few columns or a number is none.
[[nodiscard]] std::optional<std::vector<ConformanceCase>> readCases(const std::string& table);

/// Compares strings, one for each step from 0 on, with the text of a file of `step TAB string` lines. Returns the first
/// difference as a sentence that names the `which` string and the step, with both strings; an empty text when all
/// agree. `largest` becomes the largest deviation that was accepted, with its step, when it is larger than what it
/// holds.
[[nodiscard]] std::string compareSteps(const std::vector<std::string>& strings, const std::string& expected,
                                       const char* which, const Tolerance& tolerance, Deviation& largest);

/// The strings in lines of `step TAB string`, steps counted from 0. Nothing when a line has another form; `problem`
/// then says which line, what it is and what was expected.
[[nodiscard]] std::optional<std::vector<std::string>> readSteps(const std::string& output, std::string& problem);

}  // namespace espalier::conformance

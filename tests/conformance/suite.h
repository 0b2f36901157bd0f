#pragma once

#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "engine/core/identifiers.h"
#include "tests/conformance/string_comparison.h"

namespace espalier::test {

/// One line of cases/cases.tsv.
struct ConformanceCase {
  std::string name;
  std::string kind;  // deterministic, stochastic, random, environment
  std::uint64_t steps = 0;
  Tolerance tolerance;
  bool isQuirk = false;
  bool hasTurtleFile = false;
};

inline std::ostream& operator<<(std::ostream& stream, const ConformanceCase& entry) {
  return stream << entry.name;
}

/// All cases of the suite in the order of the table. Throws std::runtime_error when the table cannot be read.
[[nodiscard]] std::vector<ConformanceCase> readCases();

/// A list of case names with the reason why each is on it, as `name reason...` lines; `#` starts a comment line.
[[nodiscard]] std::map<std::string, std::string> readExceptions(const std::string& file);

/// Folder of the cases, and of this test with its lists.
[[nodiscard]] std::string casesFolder();
[[nodiscard]] std::string listFile(const std::string& name);

/// Runs a case and compares everything that the suite recorded for it: derived strings of all steps, answered strings,
/// log. Returns the first difference as a sentence with its step, or an empty text when all agree. `largest` becomes
/// the largest deviation that was accepted, with its step.
[[nodiscard]] std::string runCase(const ConformanceCase& entry, core::Compatibility compatibility, Deviation& largest);

/// What a runner with a list of exceptions has to say: empty when the case passes and is not listed, or fails and is
/// listed. `difference` is what runCase returned, `list` the list's file name.
[[nodiscard]] std::string judge(const ConformanceCase& entry, const std::string& difference,
                                const std::map<std::string, std::string>& exceptions, const std::string& list);

}  // namespace espalier::test

#pragma once

#include <map>
#include <string>
#include <vector>

#include "clients/espalier/conformance/suite_cases.h"
#include "engine/core/identifiers.h"

namespace espalier::test {

using conformance::ConformanceCase;
using conformance::Deviation;

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

/// The message of a runner with a list of exceptions: empty when the case passes and is not listed, or fails and is
/// listed. `difference` is what runCase returned, `list` the list's file name.
[[nodiscard]] std::string judge(const ConformanceCase& entry, const std::string& difference,
                                const std::map<std::string, std::string>& exceptions, const std::string& list);

}  // namespace espalier::test

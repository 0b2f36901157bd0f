#pragma once

#include <string>

#include "clients/espalier/conformance/program_output.h"
#include "clients/espalier/conformance/suite_cases.h"

namespace espalier::conformance {

/// How a program under test is called. In both commands `{model}`, `{view}`, `{environment}`, `{folder}` and `{steps}`
/// are replaced: the files of the case (a missing one: an empty word), its folder, and the number of steps. A command
/// without `{model}` gets the model as its last word.
struct ProgramCommands {
  std::string derived;     // prints the derived strings, as expected.txt has them
  std::string answered;    // prints the strings after the interpretation pass; empty: these are not compared
  bool printsLog = false;  // `derived` prints what the model's printf writes, and nothing else, on standard error
  ProgramLimits limits;
};

/// Runs a case of the suite in `folder` by a program and compares what it prints. Returns the first difference as a
/// sentence, or an empty text when all agree. `largest` as for compareSteps.
[[nodiscard]] std::string runCase(const ConformanceCase& entry, const std::string& folder,
                                  const ProgramCommands& commands, Deviation& largest);

}  // namespace espalier::conformance

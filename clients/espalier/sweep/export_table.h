#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clients/espalier/sweep/plan.h"
#include "clients/espalier/sweep/run_table.h"

namespace espalier::command {

/// Writes the results of a file as a table: a line of names, then a line for each run by its number, without times. An
/// empty `output` is standard output. Missing runs are an error unless `isPartial`. A sentence when it fails.
[[nodiscard]] std::optional<std::string> exportTable(const std::string& file, const std::string& output,
                                                     bool isPartial);

/// Puts the results of parts of one sweep into one file, which may exist and hold some of them. Two files may have the
/// same run when all its values are equal. A sentence when it fails.
[[nodiscard]] std::optional<std::string> mergeResults(const std::vector<std::string>& files, const std::string& output);

/// Prints run, seed and parameters of all runs as CSV. False: standard output is closed.
[[nodiscard]] bool printTable(const Plan& plan, const RunTable& table);

}  // namespace espalier::command

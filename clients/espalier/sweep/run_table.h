#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/result.h"
#include "clients/espalier/sweep/plan.h"
#include "engine/core/streams.h"

namespace espalier::command {

/// All runs of a plan, numbered from 1: run i is row i - 1.
struct RunTable {
  std::vector<double> values;        // of the parameters of the plan, row by row (count * columns)
  std::vector<std::uint64_t> seeds;  // (count)
  std::size_t columns = 0;
  [[nodiscard]] std::size_t count() const { return seeds.size(); }
  [[nodiscard]] std::span<const double> row(std::size_t i) const { return {values.data() + i * columns, columns}; }
};

/// A slice of the runs: those with number % count == index.
struct Slice {
  std::uint64_t index = 0;
  std::uint64_t count = 1;
  [[nodiscard]] bool has(std::uint64_t run) const { return run % count == index; }
};

/// Reads `k/n`, k from 1 to n.
[[nodiscard]] Result<Slice> readSlice(std::string_view text);

/// Makes the table of a plan: reads the file of runs, or makes the design, and repeats each row for the replicates. A
/// plan that names no parameters gets those of its table. `folder` is the folder of the plan, where its files are.
[[nodiscard]] Result<RunTable> makeRuns(Plan& plan, const std::string& folder, core::FileProvider& files);

}  // namespace espalier::command

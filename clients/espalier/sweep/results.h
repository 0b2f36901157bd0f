#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/espalier/result.h"
#include "clients/espalier/sweep/run_table.h"
#include "clients/espalier/sweep/swept_model.h"

namespace espalier::command {

/// The description of a sweep in its results. Two files can be merged, and a sweep can continue, when all is equal.
struct SweepDescription {
  std::string plan;      // Plan::text
  std::string identity;  // SweptModel::identity
  std::vector<std::string> parameters;
  std::vector<std::string> measures;
  std::uint64_t runs = 0;  // of the whole plan
  std::string table;       // hash of all values and seeds

  bool operator==(const SweepDescription&) const = default;
};

/// The description of a sweep.
[[nodiscard]] SweepDescription describeSweep(const SweptModel& model, const RunTable& table);

/// One finished run.
struct ResultRow {
  std::uint64_t run = 0;
  std::uint64_t seed = 0;
  std::vector<double> parameters;
  RunOutcome outcome;
};

/// A file of results: an SQLite database with the tables `sweep` (name, value) and `runs`, which has a row for each
/// run: run, seed, the parameters, the measures (empty: no value), error (empty: none), seconds. One program at a time
/// has the file open. A transaction holds whole rows, so that no power failure and no kill halves a row.
class SweepResults {
 public:
  ~SweepResults();
  SweepResults(SweepResults&&) noexcept;

  /// Opens the file to continue it, or makes it. A problem: another program has it open, it holds another sweep (the
  /// sentence says what differs), it is no file of results.
  [[nodiscard]] static Result<SweepResults> continued(const std::string& file, const SweepDescription& description);
  /// Opens a file that exists.
  [[nodiscard]] static Result<SweepResults> existing(const std::string& file);

  [[nodiscard]] const SweepDescription& description() const;
  /// By run, from index 1: whether the file has it.
  [[nodiscard]] Result<std::vector<bool>> finishedRuns();
  [[nodiscard]] Result<std::uint64_t> count();
  /// Adds rows in one transaction. A sentence when it fails; then none is added.
  [[nodiscard]] std::optional<std::string> add(const std::vector<ResultRow>& rows);
  /// Calls `visit` with every row in the order of the runs, until it returns false. A sentence when it fails.
  [[nodiscard]] std::optional<std::string> visit(const std::function<bool(const ResultRow&)>& visit);

 private:
  struct State;
  explicit SweepResults(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// The difference between two descriptions, as a sentence; empty: none.
[[nodiscard]] std::string differenceOf(const SweepDescription& a, const SweepDescription& b);

}  // namespace espalier::command

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/turtle/environment_process.h"
#include "environment/registry.h"

namespace espalier::environment {

/// Makes query batches for tests: a query has a position and parameters, everything else has its start value.
class QueryBuilder {
 public:
  QueryBuilder() { batch_.parameterOffset.push_back(0); }

  QueryBuilder& add(const core::Vec3& position, const std::vector<double>& parameters, core::SymbolId symbol = 0) {
    batch_.module.push_back(batch_.plant.size());
    batch_.plant.push_back(0);
    batch_.symbol.push_back(symbol);
    batch_.isTransient.push_back(0);
    batch_.position.push_back(position);
    batch_.heading.push_back({0, 1, 0});
    batch_.left.push_back({-1, 0, 0});
    batch_.up.push_back({0, 0, -1});
    batch_.width.push_back(1.0);
    batch_.scale.push_back(1.0);
    batch_.parameters.insert(batch_.parameters.end(), parameters.begin(), parameters.end());
    batch_.parameterOffset.push_back(batch_.parameters.size());
    return *this;
  }
  [[nodiscard]] turtle::QueryBatch& batch() { return batch_; }

 private:
  turtle::QueryBatch batch_;
};

/// Replies by query: nothing where a parameter was not set.
using ReplyTable = std::vector<std::vector<std::optional<double>>>;

inline ReplyTable tableOf(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies) {
  ReplyTable table;
  for (std::size_t query = 0; query < queries.size(); ++query) {
    table.emplace_back();
    for (std::uint64_t k = queries.parameterOffset[query]; k < queries.parameterOffset[query + 1]; ++k) {
      table.back().push_back(replies.isSet[k] != 0 ? std::optional(replies.values[k]) : std::nullopt);
    }
  }
  return table;
}

/// One step of a process that is expected to succeed.
inline ReplyTable answersOf(turtle::EnvironmentProcess& process, const turtle::QueryBatch& queries) {
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  const auto error = process.step(queries, replies);
  EXPECT_FALSE(error.has_value()) << (error ? error->message : "");
  return tableOf(queries, replies);
}

/// A built-in process, opened in the default world.
inline std::unique_ptr<turtle::EnvironmentProcess> openProcess(std::string_view name, std::string_view configuration,
                                                               const turtle::EnvironmentContext& context = {}) {
  auto made = makeProcess(name, configuration);
  if (!made) {
    ADD_FAILURE() << core::formatDiagnostic(made.error().front());
    return nullptr;
  }
  auto process = std::move(made.value());
  const auto error = process->open(context);
  EXPECT_FALSE(error.has_value()) << (error ? error->message : "");
  return process;
}

/// The first parameters of all replies; 999 where it was not set.
inline std::vector<double> firstValues(const ReplyTable& table) {
  std::vector<double> values;
  for (const auto& row : table) {
    values.push_back(row.empty() ? 999.0 : row[0].value_or(999.0));
  }
  return values;
}

/// The values of one answer; 999 where it has none.
[[nodiscard]] inline std::vector<double> valuesOf(const std::vector<std::optional<double>>& row) {
  std::vector<double> values;
  for (const auto& value : row) {
    values.push_back(value.value_or(999.0));
  }
  return values;
}

/// The messages and hints of a failed call as one text.
template <typename Result>
std::string errorsOf(const Result& result) {
  std::string text;
  if (!result) {
    for (const core::Diagnostic& error : result.error()) {
      text += (text.empty() ? "" : "\n") + core::formatDiagnostic(error);
    }
  }
  return text;
}

}  // namespace espalier::environment

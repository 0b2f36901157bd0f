#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/core/check.h"
#include "engine/turtle/environment_process.h"
#include "environment/registry.h"

namespace espalier::validation {

/// Queries of one plant at places with parameters: one list for all (queriesAt), or one for each. Query i is for the
/// module before module 2i + 1.
[[nodiscard]] inline turtle::QueryBatch queriesWith(const std::vector<core::Vec3>& places,
                                                    const std::vector<std::vector<double>>& parameters) {
  turtle::QueryBatch queries;
  queries.parameterOffset.push_back(0);
  queries.followingOffset.push_back(0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::vector<double>& own = parameters[i % parameters.size()];
    queries.plant.push_back(0);
    queries.module.push_back(2 * i);
    queries.symbol.push_back(0);
    queries.isTransient.push_back(0);
    queries.position.push_back(places[i]);
    queries.heading.push_back({0.0, 1.0, 0.0});
    queries.left.push_back({-1.0, 0.0, 0.0});
    queries.up.push_back({0.0, 0.0, -1.0});
    queries.width.push_back(1.0);
    queries.scale.push_back(1.0);
    queries.parameters.insert(queries.parameters.end(), own.begin(), own.end());
    queries.parameterOffset.push_back(queries.parameters.size());
    queries.following.push_back(core::kNoSymbol);
    queries.followingPair.push_back(0);
    queries.followingOffset.push_back(0);
  }
  return queries;
}
[[nodiscard]] inline turtle::QueryBatch queriesAt(const std::vector<core::Vec3>& places,
                                                  const std::vector<double>& parameters) {
  return queriesWith(places, {parameters});
}

/// A built-in process, opened in the default world. A configuration that is refused is an error of the case.
[[nodiscard]] inline std::unique_ptr<turtle::EnvironmentProcess> openProcess(const std::string& name,
                                                                             const std::string& configuration) {
  auto made = environment::makeProcess(name, configuration);
  ESPALIER_CHECK(made.has_value());
  const auto error = (*made)->open({});
  ESPALIER_CHECK(!error.has_value());
  return std::move(*made);
}

[[nodiscard]] inline turtle::ReplyBatch stepOf(turtle::EnvironmentProcess& process, const turtle::QueryBatch& queries) {
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  const auto error = process.step(queries, replies);
  ESPALIER_CHECK(!error.has_value());
  return replies;
}

/// One step of a process, and what it answers.
struct ProcessRun {
  std::unique_ptr<turtle::EnvironmentProcess> process;
  turtle::ReplyBatch replies;
};
[[nodiscard]] inline ProcessRun runProcess(const std::string& name, const std::string& configuration,
                                           const turtle::QueryBatch& queries) {
  ProcessRun run{openProcess(name, configuration), {}};
  run.replies = stepOf(*run.process, queries);
  return run;
}

}  // namespace espalier::validation

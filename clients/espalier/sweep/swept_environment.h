#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/result.h"
#include "clients/espalier/sweep/plan.h"
#include "engine/core/streams.h"
#include "engine/turtle/environment_process.h"

namespace espalier::command {

/// Makes an environment that no configuration describes: a file, another process. It prints its own errors.
using EnvironmentMaker = std::function<std::unique_ptr<turtle::EnvironmentProcess>()>;

/// The configuration in a file as text that needs no other file. An empty text: it names other processes or plug-ins,
/// which an EnvironmentMaker makes.
[[nodiscard]] Result<std::string> readConfiguration(const std::string& text, const std::string& file,
                                                    core::FileProvider& files);

/// The environment of one worker. It goes from run to run and is made anew only when a run has another configuration.
class SweptEnvironment {
 public:
  /// `configuration`: JSON text of a list of built-in environments, empty: `maker` makes the environment; a null maker:
  /// there is none.
  SweptEnvironment(std::string configuration, EnvironmentMaker maker)
      : configuration_(std::move(configuration)), maker_(std::move(maker)) {}

  /// The problem with JSON pointers and the environment itself, or nothing.
  [[nodiscard]] std::optional<std::string> check(const std::vector<SweepParameter>& parameters);

  /// Makes the process for the next run, in its initial state after its open(), unless the one of the last run will do.
  /// `settings` are JSON pointers and values. True: it is another one than before.
  [[nodiscard]] Result<bool> prepare(std::span<const std::pair<std::string, double>> settings);
  /// Passes every call to the process. Valid until prepare() makes another one. Null without an environment.
  [[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> lend();

 private:
  std::string configuration_;
  EnvironmentMaker maker_;
  std::optional<std::string> made_;  // the configuration of process_
  std::unique_ptr<turtle::EnvironmentProcess> process_;
};

}  // namespace espalier::command

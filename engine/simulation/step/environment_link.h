#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "engine/core/simulation_error.h"
#include "engine/turtle/environment_process.h"
#include "engine/turtle/guarded_call.h"

namespace espalier::simulation {

/// The environment of a simulation, or none, with its description. An exception that leaves the process is an error.
class EnvironmentLink {
 public:
  explicit EnvironmentLink(std::unique_ptr<turtle::EnvironmentProcess> process) : process_(std::move(process)) {
    readDescription();
  }

  [[nodiscard]] bool exists() const { return process_ != nullptr; }
  [[nodiscard]] turtle::EnvironmentProcess* process() const { return process_.get(); }
  /// Without an environment: of a process without a name that needs nothing.
  [[nodiscard]] const turtle::EnvironmentDescription& description() const { return description_; }
  /// After open: only now the process may know what it is.
  void readDescription() {
    if (process_) {
      description_ = process_->describe();
    }
  }
  void setName(std::string name) { description_.name = std::move(name); }

  // of an environment that exists
  [[nodiscard]] std::string save() const { return process_->save(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) {
    return turtle::guardedCall(process_->describe().name, [&] { return process_->open(context); });
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) {
    return turtle::guardedCall(description_.name, [&] { return process_->restore(state); });
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) {
    return turtle::guardedCall(description_.name, [&] { return process_->step(queries, replies); });
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) {
    return turtle::guardedCall(description_.name, [&] { return process_->tick(step); });
  }

 private:
  std::unique_ptr<turtle::EnvironmentProcess> process_;
  turtle::EnvironmentDescription description_;
};

/// The error of a step, or of step 0, in which the environment fails.
[[nodiscard]] inline core::SimulationError environmentFailure(const turtle::EnvironmentError& error,
                                                              std::uint64_t step) {
  core::SimulationError failure;
  failure.code = core::SimulationErrorCode::EnvironmentFailed;
  failure.step = step;
  failure.isRetryable = error.isRetryable;
  failure.message = error.message;
  return failure;
}

}  // namespace espalier::simulation

#pragma once

#include <cstdint>
#include <exception>
#include <optional>
#include <string>
#include <utility>

#include "engine/core/diagnostic.h"

namespace espalier::core {

enum class SimulationErrorCode : std::uint8_t {
  LimitExceeded,      // a Limits value; the message names it and its bound
  NonFinite,          // a parameter, position or reply became NaN or infinite
  Model,              // the model broke a rule of the language while it ran
  EnvironmentFailed,  // the environment did not answer; the step can be tried again
  Cancelled,          // the caller asked to stop
  Snapshot,           // the snapshot cannot be read or belongs to another model
};

/// A model that fails while running. The simulation stays at its last completed step.
struct SimulationError {
  SimulationErrorCode code = SimulationErrorCode::Model;
  std::string message;        // whole sentences: the failure and its remedy
  SourceLocation location{};  // empty file: none
  std::uint64_t step = 0;     // the step that could not be completed
  std::uint32_t plant = 0;
  std::optional<std::uint64_t> module{};  // index in the string that was being read
  bool isRetryable = false;
};

/// Carries a SimulationError inside the engine. Simulation catches it and returns the error as a value.
class SimulationFailure : public std::exception {
 public:
  explicit SimulationFailure(SimulationError error) : error_(std::move(error)) {}
  [[nodiscard]] const SimulationError& error() const { return error_; }
  [[nodiscard]] SimulationError& error() { return error_; }
  [[nodiscard]] const char* what() const noexcept override { return error_.message.c_str(); }

 private:
  SimulationError error_;
};

}  // namespace espalier::core

#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/limits.h"
#include "engine/core/streams.h"
#include "engine/derivation/expressions/failure.h"
#include "engine/derivation/expressions/random_source.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Runs the code of a Program: a stack machine over doubles (engine/language/instruction.def). It works on the state
/// that attach and enter have given, and allocates nothing while it runs. Code draws its random numbers from the
/// RandomSource, whose key the caller sets.
class Evaluator {
 public:
  struct Options {
    std::uint32_t plant = 0;
    core::Limits limits;
    const std::atomic<bool>* cancelled = nullptr;
    core::MessageSink messages;
    bool canWriteFiles = false;
  };

  /// `program` and `random` must outlive the object.
  Evaluator(const language::Program& program, RandomSource& random, Options options);

  /// The plant whose statics, derivation length and stop flag code reads and changes.
  void attach(PlantState& state);
  /// The variables that code reads and changes from now on; `instance` must stay in place until the next enter.
  void enter(InstanceState& instance);
  /// Q, and the step that failures name.
  void setStep(std::uint64_t step, std::uint64_t failingStep);
  /// The module that failures name.
  void setModule(std::uint64_t module, core::ModuleTypeId type) {
    place_.hasModule = true;
    place_.module = module;
    place_.type = type;
  }
  void clearModule() { place_.hasModule = false; }
  [[nodiscard]] const FailurePlace& place() const { return place_; }

  /// The value of an expression; `frame` holds the formal parameters.
  [[nodiscard]] double value(const language::Expression& expression, double* frame) {
    switch (expression.kind) {
      case language::Expression::Kind::Constant:
        return expression.constant;
      case language::Expression::Kind::Slot:
        return frame[expression.slot];
      case language::Expression::Kind::Code:
        break;
    }
    run(expression.code, frame);
    return stack_[0];
  }

  /// Runs code; its value, if it has one, is then at the bottom of the stack. Throws SimulationFailure: too many loop
  /// iterations, cancelled.
  void run(language::CodeRange code, double* frame);

  /// The name and the present value of the variable that an instruction loads (a static, an L-system's variable, Q or
  /// Z); nothing for other instructions.
  [[nodiscard]] std::optional<std::pair<std::string, double>> variableRead(
      const language::Instruction& instruction) const;

  /// By instruction: not 0 where the code has warned. Each place warns once.
  [[nodiscard]] const std::uint8_t* hasWarned() const { return hasWarned_.data(); }

  /// Replaces Options::messages.
  void setMessages(core::MessageSink messages) { options_.messages = std::move(messages); }
  /// Is silent from now on at the places where `other`, of the same Program, has warned, and only there.
  void adoptWarnings(const Evaluator& other) { hasWarned_ = other.hasWarned_; }
  /// Warns at every place again.
  void forgetWarnings() { std::ranges::fill(hasWarned_, std::uint8_t{0}); }

  /// Reports a warning with a place in the model, if the caller has given a message sink.
  void warn(const std::string& message, core::SourceRange range) const;
  /// Throws SimulationFailure when the caller asked to stop.
  void pollCancelled() const;
  [[noreturn]] void failHere(core::SimulationErrorCode code, const std::string& what,
                             core::SourceRange range = {}) const {
    fail(*program_, place_, code, what, range);
  }

 private:
  /// Fails where a loop turns too often; looks at `cancelled` from time to time.
  void countTurn(std::uint64_t iterations, std::uint32_t at) const;
  [[nodiscard]] double call(language::Function function, std::span<const double> arguments, std::uint32_t at);
  [[nodiscard]] double* element(std::uint32_t array, std::span<const double> subscripts, std::uint32_t at);
  void warnClamped(const language::ArrayVariable& variable, std::size_t subscript, std::uint32_t at);
  void print(const std::string& format, std::span<const double> arguments) const;
  /// vvXmin and its relatives, without vvScale.
  [[nodiscard]] double viewVolume(language::Function function) const;
  // evaluator_files.cpp
  [[nodiscard]] double openFile(std::uint32_t file, std::uint16_t mode, std::uint32_t at);
  void closeFile(double handle, std::uint32_t at);
  void printToFile(double handle, const std::string& format, std::span<const double> arguments, std::uint32_t at);
  /// Fills `numbers` and returns their count.
  [[nodiscard]] double scanFile(double handle, const std::string& format, std::span<double> numbers, std::uint32_t at);
  void warnOnce(std::uint32_t at, const std::string& message);

  const language::Program* program_;
  core::Elementary elementary_;
  RandomSource* random_;
  Options options_;
  FailurePlace place_;
  double step_ = 0.0;                  // Q
  PlantState* state_ = nullptr;        // the attached plant
  InstanceState* instance_ = nullptr;  // the entered instance
  const language::LSystem* system_ = nullptr;
  std::vector<double> stack_;            // (Program::maximumStack and a margin)
  std::vector<std::uint8_t> hasWarned_;  // by instruction: each place warns once (code size)
};

}  // namespace espalier::derivation

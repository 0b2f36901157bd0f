#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/language/program.h"

namespace espalier::command {

/// A Program whose variables start with values that change from run to run, without compiling it again. The value of a
/// variable takes the place of every value that the block Start assigns to it. Everything that Start computes from the
/// variable follows.
class StartValues {
 public:
  /// `variables` are slots of the main L-system's variables.
  StartValues(const language::Program& program, const std::vector<std::size_t>& variables);

  /// Sets the values, in the order of the variables. No simulation of the Program may be running.
  void set(std::span<const double> values);
  [[nodiscard]] const std::shared_ptr<language::Program>& program() const { return program_; }

 private:
  std::shared_ptr<language::Program> program_;
  std::size_t firstConstant_ = 0;  // of the values, in Program::constants
};

}  // namespace espalier::command

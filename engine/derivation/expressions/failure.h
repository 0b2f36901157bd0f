#pragma once

#include <cstdint>
#include <string>

#include "engine/core/simulation_error.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// A place in a derivation, with which the message of a failure begins.
struct FailurePlace {
  std::uint64_t step = 0;  // the step that cannot be completed; 0: rewinding
  std::uint32_t plant = 0;
  bool hasModule = false;
  std::uint64_t module = 0;                       // index in the string that is being read
  core::ModuleTypeId type = core::kNoModuleType;  // its type
};

/// Throws the SimulationFailure "step 41, plant 0, module 1093 ('B', tree.l:15:3): WHAT. The simulation stays at
/// step 40." `what` has no final full stop; an empty range names no place in the model.
[[noreturn]] void fail(const language::Program& program, const FailurePlace& place, core::SimulationErrorCode code,
                       const std::string& what, core::SourceRange range = {});

/// The model's text in a range, with runs of blanks and newlines folded to one blank.
[[nodiscard]] std::string sourceText(const language::Program& program, core::SourceRange range);

/// The name of a value that is not finite: "NaN" or "infinite".
[[nodiscard]] const char* nonFiniteName(double value);

}  // namespace espalier::derivation

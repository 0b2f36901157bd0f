#pragma once

#include <optional>
#include <span>

#include "engine/language/program.h"

namespace espalier::derivation {

/// Whether viewValue computes the function: func, the curve functions and inblob.
[[nodiscard]] constexpr bool isViewFunction(language::Function function) {
  return function >= language::Function::Func && function <= language::Function::InBlob;
}

/// The value of a function that the view file defines; nothing when the view file has none of that number.
[[nodiscard]] std::optional<double> viewValue(const files::ViewSettings& view, language::Function function,
                                              std::span<const double> arguments);

/// The warning about a missing one.
[[nodiscard]] const char* missingViewFunction(language::Function function);

}  // namespace espalier::derivation
